"""Parameters of a model estimated from measured modes: the most probable ones, and what stays possible.

Between the modes of a model such an error is a random symmetric matrix, the same share of every mode (Soize,
Probabilistic Engineering Mechanics 15 (2000), 277). It moves each frequency. It mixes each shape with the others, the
more the nearer their frequencies are (Fox, Kapoor, AIAA Journal 6 (1968), 2426). So errors at the points of a shape go
together.

No model is exact. By how much its stiffness and mass are off, and its shapes besides, is inferred beside the
parameters: a ladder of both is weighed by its evidence (Laplace) about the best fit, and the posterior is the mixture
over it (Kennedy and O'Hagan, "Bayesian calibration of computer models", J. R. Stat. Soc. B 63, 2001, 425). What a rig
states of uneven stiffness and mass acts in any case: it moves the lowest modes most, and higher ones do not show it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import least_squares, linear_sum_assignment

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.identification.selection.criteria import mac
from modallab.updating.beam_model import Predictor, checked_predictor
from modallab.updating.result import ModeCheck, ModeData, Prior, UpdatedParameters

NEAREST = 1e-3
"""Relative difference of two frequencies below which their modes mix as if they differed by this."""


def model_error_covariance(frequency_hz: Real, shapes: Real, places: NDArray[np.int64]) -> Real:
    """Covariance of errors of a model's modes, of such a size that frequencies have unit relative variance.

    Args:
        frequency_hz: (all modes,) of the model, Hz.
        shapes: (all modes, freedoms) at unit modal mass, kg^-1/2.
        places: (modes,) which of them were measured.

    Returns:
        (modes + modes * freedoms, the same) of logarithms of the frequencies measured, then of their shapes.
    """
    count, modes = frequency_hz.size, len(places)
    square, apart = frequency_hz**2, _squares_apart(frequency_hz)
    rows = np.arange(modes)
    mixing = np.zeros((2, modes, count, count, count))
    for r, own in zip(rows, places, strict=True):
        for q in range(count):
            share = np.array([np.sqrt(square[own] * square[q]), -square[own]]) / apart[own, q]
            # One error is shared by both modes that it couples.
            mixing[:, r, q, min(own, q), max(own, q)] = share
        mixing[:, r, own, own, own] = 0.0, -np.sqrt(0.5)
    moved = np.zeros((2, modes, count, count))
    moved[:, rows, places, places] = np.sqrt(0.5) * np.array([[1.0], [-1.0]])
    at_points = np.einsum("erqij,qf->rfeij", mixing, shapes).reshape(shapes.shape[1] * modes, -1)
    factor = np.concatenate([moved.swapaxes(0, 1).reshape(modes, -1), at_points])
    return np.asarray(factor @ factor.T, np.float64)


def _squares_apart(frequency_hz: Real) -> Real:
    """(modes, modes) differences of squared frequencies, none nearer to 0 than `NEAREST` makes it."""
    square = frequency_hz**2
    apart = square[:, None] - square
    least = 2 * NEAREST * frequency_hz[:, None] * frequency_hz
    return np.copysign(np.maximum(np.abs(apart), least), apart)


OFF_HZ = (3e-4, 1e-3, 3e-3, 1e-2, 3e-2)
"""By how much a model's stiffness and mass may move its frequencies, relative."""
OFF_SHAPE = (1e-2, 3e-2, 0.1, 0.3)
"""By how much its shapes may be off besides, over their root mean square."""
FIRST = ((0.1, 1.0), (3e-2, 0.3), (1e-2, 0.1))
"""Where the search begins: narrow valleys are not followed from afar."""
TRIED, STARTS = 64, 4
"""Numbers drawn from the priors, and how many of them a search begins at: close modes leave several valleys."""
TURNS = 3
FEW, STEPS = 8, 60
"""Steps of a search that others follow, and of one to the end."""
STEP = 1e-4
"""Of the derivatives, in standard deviations of the priors."""
IMPOSSIBLE = 1e3
"""Misfit of numbers that no structure can have."""
DRAWS = 4000
FARTHEST = 30.0
"""Standard deviations of the prior from its centre that a search goes at most."""


@dataclass(frozen=True, eq=False, slots=True)
class _LinearisedFit:
    """A linearisation about the best numbers.

    Attributes:
        u: (parameters,) in standard deviations of the priors.
        misfit: (numbers,) predicted less measured.
        slopes: (numbers, parameters) of it.
    """

    u: Real
    misfit: Real
    slopes: Real


@dataclass(frozen=True, eq=False, slots=True)
class _UpdatingProblem:
    """Measured modes, a model and what is believed of its parameters.

    Attributes:
        predict: the model.
        priors: what is believed.
        data: measured modes.
        error: (numbers, numbers) covariance of what moves the model's frequencies by their value.
    """

    predict: Predictor
    priors: Mapping[str, Prior]
    data: ModeData
    error: Real

    def about(self, u: Real) -> "_UpdatingProblem":
        """The same with the errors that the model has near some numbers."""
        hz, shapes = self.predict(self.numbers(u))
        places, signs = pair_modes(self.data, hz, shapes)
        turned = shapes.copy()
        turned[places] *= signs[:, None]
        size = np.concatenate([np.ones(self.data.modes), np.repeat(self.data.size[:, 0], shapes.shape[1])])
        return replace(self, error=model_error_covariance(hz, turned, places) / np.outer(size, size))

    def numbers(self, u: Real) -> dict[str, float]:
        return {name: float(prior.at(x)) for (name, prior), x in zip(self.priors.items(), u, strict=True)}

    def misfit(self, u: Real) -> Real:
        try:
            hz, shapes = self.predict(self.numbers(u))
        except (DataError, np.linalg.LinAlgError):
            # Such as a mass below 0 that is more than there is: a step to there is rejected.
            return np.full(len(self.data.covariance), IMPOSSIBLE)
        places, signs = pair_modes(self.data, hz, shapes)
        return self.data.misfit(hz[places], signs[:, None] * shapes[places])

    def slopes(self, u: Real) -> Real:
        here = self.misfit(u)
        return np.stack([(self.misfit(u + h) - here) / STEP for h in STEP * np.eye(u.size)], axis=1)

    def covariance(self, off: tuple[float, float]) -> Real:
        own = np.repeat((0.0, off[1] ** 2), (self.data.modes, self.data.shapes.size))
        return self.data.covariance + (off[0] ** 2 + self.data.uneven**2) * self.error + np.diag(own)

    def starts(self) -> list[Real]:
        """The numbers that are believed, and those of many draws that are most like the test."""
        draws = np.random.default_rng(0).standard_normal((TRIED, len(self.priors)))
        factor = np.linalg.cholesky(self.covariance(FIRST[0]))
        cost = [np.sum(solve_triangular(factor, self.misfit(u), lower=True) ** 2) + u @ u for u in draws]
        return [np.zeros(len(self.priors)), *draws[np.argsort(cost)[: STARTS - 1]]]

    def found(self) -> Real:
        """The best numbers of several searches, each from where much may be off to where little is."""
        ends = [self.fit(u, FIRST[0], FEW) for u in self.starts()]
        for off in FIRST[1:]:
            ends = [self.fit(end.u, off, FEW) for end in ends]
        return min(ends, key=lambda end: self.weighed(end, FIRST[-1])[0]).u

    def fit(self, u: Real, off: tuple[float, float], steps: int = STEPS) -> _LinearisedFit:
        """The most probable numbers for what the model is off by."""
        factor = np.linalg.cholesky(self.covariance(off))

        def weighed(a: Real) -> Real:
            return solve_triangular(factor, a, lower=True)

        found = least_squares(
            lambda v: np.concatenate([weighed(self.misfit(v)), v]),
            u,
            lambda v: np.concatenate([weighed(self.slopes(v)), np.eye(v.size)]),
            bounds=(-FARTHEST, FARTHEST),
            x_scale=1.0,
            max_nfev=steps,
        )
        return _LinearisedFit(found.x, self.misfit(found.x), self.slopes(found.x))

    def settled(self) -> tuple[Real, tuple[float, float], list[tuple[float, Real, Real]]]:
        """The best numbers at the most probable scales, and the mixture about them."""
        u, off, parts = self.found(), FIRST[-1], list[tuple[float, Real, Real]]()
        for _ in range(TURNS):
            here = self.about(u)
            fit = here.fit(u, off)
            u, (off, parts) = fit.u, here.mixture(fit)
        return u, off, parts

    def weighed(self, fit: _LinearisedFit, off: tuple[float, float]) -> tuple[float, Real, Real]:
        """-2 ln of the evidence there, the mean and the covariance of u."""
        factor = cho_factor(self.covariance(off), lower=True)
        by, centre = cho_solve(factor, fit.slopes), fit.misfit - fit.slopes @ fit.u
        curvature = fit.slopes.T @ by + np.eye(fit.u.size)
        mean = -np.asarray(np.linalg.solve(curvature, by.T @ centre), np.float64)
        left = centre + fit.slopes @ mean
        cost = left @ cho_solve(factor, left) + mean @ mean + 2 * np.sum(np.log(np.diag(factor[0])))
        return float(cost + np.linalg.slogdet(curvature)[1]), mean, np.asarray(np.linalg.inv(curvature), np.float64)

    def mixture(self, fit: _LinearisedFit) -> tuple[tuple[float, float], list[tuple[float, Real, Real]]]:
        """The most probable scales, and the weight, mean and covariance at each."""
        ladder = [(a, b) for a in OFF_HZ for b in OFF_SHAPE]
        each = [self.weighed(fit, off) for off in ladder]
        evidence = np.array([e for e, _, _ in each])
        weight = np.exp((evidence.min() - evidence) / 2)
        best = ladder[int(np.argmin(evidence))]
        return best, [(w / weight.sum(), mean, cov) for w, (_, mean, cov) in zip(weight, each, strict=True)]


def update_parameters(
    predict: Predictor, priors: Mapping[str, Prior], data: ModeData, held_out: Sequence[int] = ()
) -> UpdatedParameters:
    """The parameters of a model that measured modes leave possible.

    Args:
        predict: numbers by name -> frequencies and shapes at the freedoms of the data.
        priors: what is believed of each parameter.
        data: measured modes.
        held_out: modes, from 1, that the estimate does not see, and that check it.

    Raises:
        DataError: no parameter, no such mode, fewer than two modes to learn from, or a model without enough modes.
    """
    if not priors:
        raise DataError("there is no parameter to estimate", remedy="give priors")
    predict = checked_predictor(predict, data.shapes.shape[1])
    before = _check_problem(predict, {name: prior.value for name, prior in priors.items()}, data)
    kept = data.of_modes(_modes_to_fit(data.modes, held_out))
    problem = _UpdatingProblem(predict, priors, kept, np.zeros(0)).about(np.zeros(len(priors)))
    u, off, parts = problem.settled()
    drawn = _draw_from_mixture(parts)
    return UpdatedParameters(
        priors=dict(priors),
        numbers=problem.numbers(u),
        interval={
            name: tuple(np.quantile(prior.at(drawn[:, n]), (0.025, 0.975)).tolist())
            for n, (name, prior) in enumerate(priors.items())
        },
        narrowed=np.std(drawn, axis=0),
        correlation=np.atleast_2d(np.corrcoef(drawn.T)),
        off=(float(np.hypot(off[0], kept.uneven)), off[1]),
        measured_hz=data.frequency_hz,
        measured_sigma_hz=data.frequency_sigma_hz,
        before=before,
        after=_check_problem(predict, problem.numbers(u), data),
        held_out=tuple(held_out),
    )


def _modes_to_fit(modes: int, held_out: Sequence[int]) -> list[int]:
    wrong = [r for r in held_out if not 1 <= r <= modes]
    if wrong:
        raise DataError(f"there is no mode {wrong[0]} to hold out", remedy=f"name modes from 1 to {modes}")
    kept = [r for r in range(modes) if r + 1 not in held_out]
    if len(kept) < 2:
        raise DataError(f"{len(kept)} modes remain for the estimate", remedy="hold out fewer modes")
    return kept


def _draw_from_mixture(parts: list[tuple[float, Real, Real]]) -> Real:
    """(draws, parameters) of a mixture of normal distributions."""
    rng = np.random.default_rng(0)
    counts = rng.multinomial(DRAWS, [w for w, _, _ in parts])
    return np.concatenate(
        [rng.multivariate_normal(mean, cov, n) for n, (_, mean, cov) in zip(counts, parts, strict=True) if n]
    )


def _check_problem(predict: Predictor, numbers: Mapping[str, float], data: ModeData) -> ModeCheck:
    hz, shapes = predict(numbers)
    places, _ = pair_modes(data, hz, shapes)
    found = shapes[places]
    alike = np.sum(found * data.shapes, axis=1) ** 2
    mac = alike / np.sum(found**2, axis=1) / np.sum(data.shapes**2, axis=1)
    return ModeCheck(hz[places], mac)


def pair_modes(data: ModeData, frequency_hz: Real, shapes: Real) -> tuple[NDArray[np.int64], Real]:
    """Place of the predicted mode of each measured one, and its sign.

    Few points make shapes alike whose frequencies lie far apart: the MAC counts less by the ratio of frequencies.

    Raises:
        DataError: the model has fewer modes than were measured.
    """
    if frequency_hz.size < data.modes:
        raise DataError(
            f"the model has {frequency_hz.size} modes, and {data.modes} were measured", remedy="compute more modes"
        )
    apart = np.abs(np.log(frequency_hz / data.frequency_hz[:, None]))
    _, places = linear_sum_assignment(-mac(data.shapes, shapes) * np.exp(-apart))
    signs = np.sign(np.sum(shapes[places] * data.shapes, axis=1))
    return places, np.where(signs == 0, 1.0, signs)
