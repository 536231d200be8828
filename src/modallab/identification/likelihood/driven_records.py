"""The likelihood of records of one random force, noise on the force included.

Noise on the force leaves a residual in all responses at once, as large as their FRF: near resonance it is by far the
largest. About a line, given the measured force, the responses are normal with the mean H F and the covariance
D + beta H H^H, D the noise of each response. What rings at a record's ends is a state of every mode. Poles, residues,
states and both noises are those of the largest likelihood; all lines and all records count.

Responses and force alone do not say whether the noise lies on the force channel or in a force that was not measured.
H1 takes it for the latter and is right then, H2 for the former. With P the power of the measured force, S that of its
noise and kappa = 1 - S / P, the force is kappa F of H2, sqrt(kappa) F of Hv, F of H1.
Source: errors in the variables after Pintelon and Schoukens, "System Identification", 2nd ed. (2012), section 8.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage, optimize

from modallab.frf.joined import RecordSpectra
from modallab.identification.likelihood.basis import BlockColumns, columns
from modallab.identification.likelihood.derivatives import Vectors
from modallab.identification.likelihood.excitation import Grid, RandomExcitation
from modallab.identification.likelihood.rows import unstack
from modallab.identification.likelihood.search import MIN_ZETA, covariance_of

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEPS = 12
SETTLED = 0.01
"""A step that lowers the cost by less, a sum of squares in noise units, ends the search."""
HALVED = 5
AT_ONCE = 2000
"""Lines that are worked on at once."""
SMOOTHED = 101
"""Lines over which the force's power is averaged."""
LEAST_NOISE, LEAST_TRUE = 1e-12, 0.05
"""Shares of a force's power that are noise, and are not, at least."""
OF_H2 = {"H1": 0.0, "Hv": 0.5, "H2": 1.0}


@dataclass(frozen=True, eq=False, slots=True)
class Driven:
    """The model of records.

    Attributes:
        omega: (modes,) rad/s.
        zeta: (modes,)
        coefficients: (columns, outputs) real and imaginary part of each mode's residues, then residual terms.
        state: (records, modes)
        noise: (outputs,) standard deviation of a line of each response.
        force_noise: power of the noise on a line of the force.
        covariance: of omega and zeta mode by mode, then of each output's coefficients, then of the states.
    """

    omega: Real
    zeta: Real
    coefficients: Real
    state: Complex
    noise: Real
    force_noise: float
    covariance: Real


@dataclass(frozen=True, eq=False, slots=True)
class _Look:
    """A model at the lines of one record, in noise units: what is left, and how the force's noise enters.

    Attributes:
        columns: of the record.
        left: (outputs, lines).
        frf: (outputs, lines).
        common: (lines,) factor of the force's noise power.
        weight: (lines,) 1 / (1 / beta + H^H H).
        along: (lines,) H^H left.
    """

    columns: BlockColumns
    left: Complex
    frf: Complex
    common: Real
    weight: Real
    along: Complex

    @property
    def cost(self) -> float:
        """Sum of squares in noise units, two for a complex number."""
        return 2 * float(np.sum(np.abs(self.left) ** 2) - np.sum(self.weight * np.abs(self.along) ** 2))


@dataclass(frozen=True, eq=False, slots=True)
class _Spread:
    """What is left of all records, as `_Look` has it, and how likely it is for noises."""

    left: Complex
    frf: Complex
    common: Real

    def cost(self, logs: Real) -> tuple[float, Real]:
        """Minus the logarithm of the likelihood by that of the noises' powers, the force's last, and its slope."""
        power, beta = np.exp(logs[:-1])[:, None], np.exp(logs[-1]) * self.common
        square = np.abs(self.frf) ** 2 / power
        weight = beta / (1 + beta * square.sum(axis=0))
        force = weight * np.sum(self.frf.conj() * self.left / power, axis=0)
        own = np.abs(self.left) ** 2 / power
        value = logs[:-1].sum() * beta.size - np.sum(np.log(weight / beta)) + own.sum()
        value -= np.sum(np.abs(force) ** 2 / weight)
        by_output = beta.size - np.sum(np.abs(self.left - self.frf * force) ** 2 / power + weight * square, axis=1)
        by_force = beta.size - np.sum((np.abs(force) ** 2 + weight) / beta)
        return float(value) / beta.size, np.append(by_output, by_force) / beta.size


class DrivenFit:
    """The search.

    Args:
        records: of one force.
        powers: of s of the receptance's residual terms.
        p: times the responses are differentiated.
        estimator: whose the noise on the force is taken to be: H1, H2 or Hv.
    """

    def __init__(self, records: RecordSpectra, powers: Sequence[int], p: int, estimator: str) -> None:
        self._response, self._force = records.response, records.force[:, 0]
        self._powers, self._share = tuple(powers), OF_H2[estimator]
        self._grid = Grid(2 * np.pi * records.frequency_hz, records.samples, 1 / records.rate_hz, p)
        power = np.mean(np.abs(self._force) ** 2, axis=0)
        self.power = ndimage.uniform_filter1d(power, min(SMOOTHED, power.size))

    def search(self, omega: Real, zeta: Real, coefficients: Real) -> Driven:
        """The most likely model, from a model of FRFs.

        Raises:
            IdentificationError: poles that cannot be distinguished.
        """
        at = self._start(omega, zeta, coefficients)
        for _ in range(STEPS):
            at = self._noises(at)
            matrix, gradient = self._equations(at)
            step = _solved(matrix, gradient)
            after = self._shorter(at, step)
            if after is None or step @ gradient < SETTLED:
                break
            at = after
        at = self._noises(at)
        return replace(at, covariance=covariance_of(self._equations(at)[0]))

    def true_share(self, force_noise: float) -> Real:
        """(lines,) of the measured force's power that is not noise."""
        return np.maximum(1 - force_noise / self.power, LEAST_TRUE)

    def _start(self, omega: Real, zeta: Real, coefficients: Real) -> Driven:
        state = np.zeros((len(self._force), omega.size), complex)
        ones = np.ones(coefficients.shape[1])
        at = Driven(omega, zeta, coefficients, state, ones, 0.0, np.zeros((0, 0)))
        left = np.array([np.mean(np.abs(one.left) ** 2, axis=1) for one in self._looks(at)]).mean(axis=0)
        noise = np.maximum(np.sqrt(left / 2), np.finfo(float).tiny)
        return replace(at, noise=noise, force_noise=1e-3 * float(self.power.mean()))

    def _looks(self, at: Driven, spread: Complex | None = None) -> list[_Look]:
        """Of all records; `spread` is the FRF by which the force's noise enters, None for the model's own."""
        return [self._look(at, k, spread) for k in range(len(self._force))]

    def _look(self, at: Driven, record: int, spread: Complex | None) -> _Look:
        true = self.true_share(at.force_noise)
        force = self._force[record]
        driven = RandomExcitation(self._grid, true**self._share * force)
        found = columns(driven, at.omega, at.zeta, at.state[record], None, self._powers)
        unit = columns(RandomExcitation(driven.grid, np.ones_like(force)), at.omega, at.zeta, None, None, self._powers)
        scaled = (at.coefficients / at.noise).T
        left = self._response[record] / at.noise[:, None] - scaled @ unstack(found.phi)
        frf = scaled @ unstack(unit.phi) if spread is None else spread
        common = true ** (2 * self._share - 1)
        square = np.sum(np.abs(frf) ** 2, axis=0)
        beta = at.force_noise * common
        return _Look(found, left, frf, common, beta / (1 + beta * square), np.sum(frf.conj() * left, axis=0))

    def _noises(self, at: Driven) -> Driven:
        """The most likely noises for a model."""
        looks = self._looks(at)
        spread = _Spread(*(np.concatenate([getattr(o, n) for o in looks], axis=-1) for n in ("left", "frf", "common")))
        outputs, count = spread.left.shape
        lost = (at.omega.size * (1 + len(looks)) / outputs + len(at.coefficients) / 2) / count
        least = np.log(LEAST_NOISE * float(self.power.mean()))
        found = optimize.minimize(
            spread.cost,
            np.append(np.zeros(outputs), max(np.log(at.force_noise), least)),
            jac=True,
            method="L-BFGS-B",
            bounds=[(-20.0, 20.0)] * outputs + [(least, None)],
        ).x
        free = max(1 - lost, 0.1)
        return replace(
            at, noise=at.noise * np.exp(found[:-1] / 2) / np.sqrt(free), force_noise=float(np.exp(found[-1]))
        )

    def _shorter(self, at: Driven, step: Real) -> Driven | None:
        """The step, or as much of it as lowers the cost at the covariance there is."""
        looks = self._looks(at)
        before = sum(one.cost for one in looks)
        for k in range(HALVED):
            trial = _moved(at, step / 2**k)
            with np.errstate(over="ignore", invalid="ignore"):
                if sum(one.cost for one in self._looks(trial, looks[0].frf)) <= before:
                    return trial
        return None

    def _equations(self, at: Driven) -> tuple[Real, Real]:
        """Normal equations of all parameters, in noise units."""
        modes, linear = at.omega.size, at.coefficients.size
        size = 2 * modes * (1 + len(at.state)) + linear
        matrix, gradient = np.zeros((size, size)), np.zeros(size)
        for k, look in enumerate(self._looks(at)):
            state = 2 * modes * (1 + k) + linear + np.arange(2 * modes)
            index = np.concatenate([np.arange(2 * modes), state, 2 * modes + np.arange(linear)])
            for first in range(0, look.along.size, AT_ONCE):
                part, slope = _of_lines(look, at, slice(first, first + AT_ONCE))
                matrix[np.ix_(index, index)] += part
                gradient[index] += slope
        return matrix, gradient


def _of_lines(look: _Look, at: Driven, lines: slice) -> tuple[Real, Real]:
    """Of some lines of a record: poles, states, then coefficients output by output."""
    left, frf, weight, along = look.left[:, lines], look.frf[:, lines], look.weight[lines], look.along[lines]
    slopes = np.concatenate([_slopes(v, at, lines) for v in (look.columns.poles, look.columns.local)])
    phi = unstack(look.columns.phi)[:, lines]
    outputs, n, searched = len(left), len(phi), len(slopes)
    shared = np.concatenate(
        [
            np.einsum("ol,sol->sl", frf.conj(), slopes),
            (frf.conj()[:, None] * phi / at.noise[:, None, None]).reshape(outputs * n, -1),
        ]
    )
    matrix = -((shared * weight) @ shared.conj().T).real
    flat = slopes.reshape(searched, -1)
    matrix[:searched, :searched] += (flat @ flat.conj().T).real
    cross = ((slopes @ phi.conj().T).real / at.noise[:, None]).reshape(searched, -1)
    matrix[:searched, searched:] += cross
    matrix[searched:, :searched] += cross.T
    gram = (phi @ phi.conj().T).real
    for o in range(outputs):
        own = slice(searched + o * n, searched + (o + 1) * n)
        matrix[own, own] += gram / at.noise[o] ** 2
    linear = ((left @ phi.conj().T).real / at.noise[:, None]).ravel()
    gradient = np.concatenate([(flat.conj() @ left.ravel()).real, linear])
    return 2 * matrix, 2 * (gradient - (shared.conj() @ (weight * along)).real)


def _slopes(vectors: Vectors, at: Driven, lines: slice) -> Complex:
    """(parameters, outputs, lines) of the responses, in noise units."""
    values = unstack(vectors.values)[:, lines]
    each = (at.coefficients / at.noise)[vectors.column][:, :, None] * values[:, None]
    starts = np.flatnonzero(np.diff(vectors.parameter, prepend=-1))
    return np.add.reduceat(each, starts, axis=0)


def _solved(matrix: Real, gradient: Real) -> Real:
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * np.outer(scale, scale) + 1e-10 * np.eye(len(scale))
    return scale * linalg.solve(scaled, scale * gradient, assume_a="sym")


def _moved(at: Driven, step: Real) -> Driven:
    modes, linear = at.omega.size, at.coefficients.size
    poles, coefficients = step[: 2 * modes].reshape(modes, 2), step[2 * modes : 2 * modes + linear]
    states = step[2 * modes + linear :].reshape(*at.state.shape, 2)
    return replace(
        at,
        omega=at.omega * np.clip(1 + poles[:, 0] / at.omega, 0.99, 1.01),
        zeta=np.maximum(at.zeta + poles[:, 1], np.maximum(at.zeta / 4, MIN_ZETA)),
        coefficients=at.coefficients + coefficients.reshape(at.coefficients.shape[::-1]).T,
        state=at.state + states[..., 0] + 1j * states[..., 1],
    )
