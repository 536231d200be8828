"""Records of one random force fitted as they are, noise on the force included.

Noise on the force leaves a residual in all responses at once, as large as their FRF: near resonance it is by far the
largest. About a line, given the measured force, the responses have the mean H F and the covariance D + beta H H^H, D
the noise of each response. What rings at a record's ends is a state of every mode. Each line of each response counts
by its own variance; the covariance of what is found is that of these equations, with what responses share.

Responses and force alone do not say whether the noise lies on the force channel or in a force that was not measured.
H1 takes it for the latter and is right then, H2 for the former. With P the power of the measured force, S that of its
noise and kappa = 1 - S / P, the force is kappa F of H2, sqrt(kappa) F of Hv, F of H1.
Sources: Pintelon and Schoukens, "System Identification", 2nd ed. (2012), section 8; for the covariance Liang and Zeger,
"Longitudinal data analysis using generalized linear models", Biometrika 73 (1986).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, ndimage, optimize

from modallab.core.arrays import Complex128, Real
from modallab.frf.joined import RecordSpectra
from modallab.identification.likelihood.basis import BlockColumns, DerivativeVectors, columns_of_block
from modallab.identification.likelihood.equations import covariance_of
from modallab.identification.likelihood.excitation import BlockLines, RandomExcitation
from modallab.identification.likelihood.orthonormal import complex_lines
from modallab.identification.likelihood.search import MIN_ZETA

STEPS, TRIALS, LEAST_DAMPING = 40, 8, 1e-8
SETTLED = 0.01  # A step that lowers the cost by less, a sum of squares in noise units, ends the search.
AT_ONCE, SMOOTHED = 2000, 101  # Lines that are worked on at once, and over which the force's power is averaged.
LEAST_NOISE, LEAST_TRUE = 1e-12, 0.05  # Shares of a force's power that are noise, and are not.
OF_H2 = {"H1": 0.0, "Hv": 0.5, "H2": 1.0}


@dataclass(frozen=True, eq=False, slots=True)
class DrivenModel:
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
    state: Complex128
    noise: Real
    force_noise: float
    covariance: Real


@dataclass(frozen=True, eq=False, slots=True)
class _RecordResidual:
    """A model at the lines of one record, in noise units: what is left, and how the force's noise enters.

    Attributes:
        columns: of the record.
        left: (outputs, lines).
        frf: (outputs, lines).
        beta: (lines,) power by which the force's noise enters.
        common: (lines,) the same of a noise of power 1.
    """

    columns: BlockColumns
    left: Complex128
    frf: Complex128
    beta: Real
    common: Real

    @property
    def weight(self) -> Real:
        """(outputs, lines)."""
        return 1 / (1 + self.beta * np.abs(self.frf) ** 2)


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
        self._grid = BlockLines(2 * np.pi * records.frequency_hz, records.samples, 1 / records.rate_hz, p)
        power = np.mean(np.abs(self._force) ** 2, axis=0)
        self.power = ndimage.uniform_filter1d(power, min(SMOOTHED, power.size))

    def search(self, omega: Real, zeta: Real, coefficients: Real) -> DrivenModel:
        """The model at which the equations hold, from a model of FRFs.

        Raises:
            IdentificationError: poles that cannot be distinguished.
        """
        at, damping = self._start(omega, zeta, coefficients), 1e-3
        for _ in range(STEPS):
            at = self._noises(at)
            after, damping, gain = self._descended(at, damping)
            if after is None or gain < SETTLED:
                break
            at = after
        at = self._noises(at)
        return replace(at, covariance=self._covariance(at))

    def needed(self, found: DrivenModel, inside: NDArray[np.bool_]) -> tuple[DrivenModel, NDArray[np.int64]]:
        """The model without the modes that do not stand out of its noise, and which stay.

        What noise on the force leaves looks like a mode beside each, in fits that take noise as even.

        Args:
            found: a model.
            inside: (modes,) those to be asked for; the others stay.

        Source: Schwarz, "Estimating the dimension of a model", Annals of Statistics 6 (1978), for the criterion.
        """
        stay = np.arange(found.omega.size)
        price = 2 * (1 + found.noise.size) * np.log(self._force.size)
        while np.count_nonzero(inside[stay]) > 1:
            squares = np.where(inside[stay], _standing_out(found), np.inf)
            if squares.min() > price:
                break
            left = np.delete(np.arange(stay.size), int(squares.argmin()))
            rows = np.concatenate(
                [(2 * left[:, None] + [0, 1]).ravel(), np.arange(2 * stay.size, len(found.coefficients))]
            )
            found, stay = self.search(found.omega[left], found.zeta[left], found.coefficients[rows]), stay[left]
        return found, stay

    def true_share(self, force_noise: float) -> Real:
        """(lines,) of the measured force's power that is not noise."""
        return np.maximum(1 - force_noise / self.power, LEAST_TRUE)

    def _start(self, omega: Real, zeta: Real, coefficients: Real) -> DrivenModel:
        state = np.zeros((len(self._force), omega.size), complex)
        at = DrivenModel(omega, zeta, coefficients, state, np.ones(coefficients.shape[1]), 0.0, np.zeros((0, 0)))
        left = np.mean([np.mean(np.abs(one.left) ** 2, axis=1) for one in self._looks(at)], axis=0)
        noise = np.maximum(np.sqrt(left), np.finfo(float).tiny)
        return replace(at, noise=noise, force_noise=1e-3 * float(self.power.mean()))

    def _looks(self, at: DrivenModel) -> list[_RecordResidual]:
        return [self._look(at, k) for k in range(len(self._force))]

    def _look(self, at: DrivenModel, record: int) -> _RecordResidual:
        true = self.true_share(at.force_noise)
        driven = RandomExcitation(self._grid, true**self._share * self._force[record])
        found = columns_of_block(driven, at.omega, at.zeta, at.state[record], None, self._powers)
        unit = RandomExcitation(self._grid, np.ones_like(driven.force))
        scaled = (at.coefficients / at.noise).T
        left = self._response[record] / at.noise[:, None] - scaled @ complex_lines(found.phi)
        frf = scaled @ complex_lines(columns_of_block(unit, at.omega, at.zeta, None, None, self._powers).phi)
        common = true ** (2 * self._share - 1)
        return _RecordResidual(found, left, frf, at.force_noise * common, common)

    def _noises(self, at: DrivenModel) -> DrivenModel:
        """The most likely noises for a model."""
        looks = self._looks(at)
        left = np.concatenate([np.abs(one.left) ** 2 for one in looks], axis=1)
        spread = np.concatenate([one.common * np.abs(one.frf) ** 2 for one in looks], axis=1)
        # Noise on the force is at most all of it.
        most = float(np.log(self.power.mean()))
        least = most + np.log(LEAST_NOISE)

        def unlikely(logs: Real) -> tuple[float, Real]:
            own, of_force = np.exp(logs[:-1])[:, None], np.exp(logs[-1]) * spread
            variance = own + of_force
            slope = (1 - left / variance) / variance
            value = np.mean(np.log(variance) + left / variance)
            by_output = np.mean(slope * own, axis=1) / len(left)
            return float(value), np.append(by_output, np.mean(slope * of_force))

        start = np.append(np.zeros(len(left)), np.clip(np.log(at.force_noise), least, most))
        bounds = [(-20.0, 20.0)] * len(left) + [(least, most)]
        logs = optimize.minimize(unlikely, start, jac=True, method="L-BFGS-B", bounds=bounds).x
        return replace(at, noise=at.noise * np.exp(logs[:-1] / 2), force_noise=float(np.exp(logs[-1])))

    def _descended(self, at: DrivenModel, damping: float) -> tuple[DrivenModel | None, float, float]:
        """A step that lowers the cost at the variances there are, None without one; the next damping, and the gain."""
        looks = self._looks(at)
        matrix, gradient = self._equations(at, looks)
        weights = [one.weight for one in looks]
        before = _cost_of_residuals(looks, weights)
        for _ in range(TRIALS):
            trial = _step_model(at, _solve_damped(matrix, gradient, damping))
            with np.errstate(over="ignore", invalid="ignore"):
                gain = before - _cost_of_residuals(self._looks(trial), weights)
            if gain >= 0:
                return trial, max(damping / 10, LEAST_DAMPING), gain
            damping *= 10
        return None, damping, 0.0

    def _covariance(self, at: DrivenModel) -> Real:
        looks = self._looks(at)
        inverse, spread = covariance_of(self._equations(at, looks)[0]), np.zeros((_number_of_parameters(at),) * 2)
        for index, look, lines in _pieces_of_record(at, looks):
            spread[np.ix_(index, index)] += _spread_of(look, at, lines)
        return inverse @ spread @ inverse

    def _equations(self, at: DrivenModel, looks: Sequence[_RecordResidual]) -> tuple[Real, Real]:
        """Normal equations of all parameters in noise units."""
        matrix, gradient = np.zeros((_number_of_parameters(at),) * 2), np.zeros(_number_of_parameters(at))
        for index, look, lines in _pieces_of_record(at, looks):
            part, slope = _equations_of(look, at, lines)
            matrix[np.ix_(index, index)] += part
            gradient[index] += slope
        return matrix, gradient


def _number_of_parameters(at: DrivenModel) -> int:
    return 2 * at.omega.size * (1 + len(at.state)) + at.coefficients.size


def _pieces_of_record(
    at: DrivenModel, looks: Sequence[_RecordResidual]
) -> Iterator[tuple[NDArray[np.int64], _RecordResidual, slice]]:
    """Some lines of a record at once, and the places of its poles, states and coefficients among all parameters."""
    modes, linear = at.omega.size, at.coefficients.size
    for k, look in enumerate(looks):
        state = 2 * modes * (1 + k) + linear + np.arange(2 * modes)
        index = np.concatenate([np.arange(2 * modes), state, 2 * modes + np.arange(linear)])
        for first in range(0, look.beta.size, AT_ONCE):
            yield index, look, slice(first, first + AT_ONCE)


def _standing_out(found: DrivenModel) -> Real:
    """(modes,) sum of squares of the residues, in units of their noise."""
    n, outputs = 2 * found.omega.size, found.noise.size
    place = n + np.arange(found.coefficients.size).reshape(outputs, -1)
    squares = []
    for k in range(0, n, 2):
        index = place[:, k : k + 2].ravel()
        values = found.coefficients[k : k + 2].T.ravel()
        squares.append(values @ covariance_of(found.covariance[np.ix_(index, index)]) @ values)
    return np.array(squares)


def _cost_of_residuals(looks: Sequence[_RecordResidual], weights: Sequence[Real]) -> float:
    """Sum of squares in noise units, two for a complex number."""
    return 2 * float(sum(np.sum(w * np.abs(one.left) ** 2) for one, w in zip(looks, weights, strict=True)))


def _equations_of(look: _RecordResidual, at: DrivenModel, lines: slice) -> tuple[Real, Real]:
    """Of some lines of a record: poles, states, then coefficients output by output."""
    weight, slopes, phi = (
        look.weight[:, lines],
        _slopes_by_poles_and_states(look, at, lines),
        complex_lines(look.columns.phi)[:, lines],
    )
    weighted = weight * look.left[:, lines]
    linear = ((weighted @ phi.conj().T).real / at.noise[:, None]).ravel()
    gradient = np.concatenate([np.einsum("sol,ol->s", slopes.conj(), weighted).real, linear])
    return 2 * _products_of_slopes(slopes, phi, weight, at.noise), 2 * gradient


def _spread_of(look: _RecordResidual, at: DrivenModel, lines: slice) -> Real:
    """Covariance of the right-hand side of the equations of some lines."""
    weight, slopes, phi = (
        look.weight[:, lines],
        _slopes_by_poles_and_states(look, at, lines),
        complex_lines(look.columns.phi)[:, lines],
    )
    along = weight * look.frf[:, lines].conj()
    of_linear = (along[:, None] * phi / at.noise[:, None, None]).reshape(-1, phi.shape[1])
    shared = np.concatenate([np.einsum("ol,sol->sl", along, slopes), of_linear])
    spread = (
        _products_of_slopes(slopes, phi, weight**2, at.noise) + ((shared * look.beta[lines]) @ shared.conj().T).real
    )
    return 2 * spread


def _slopes_by_poles_and_states(look: _RecordResidual, at: DrivenModel, lines: slice) -> Complex128:
    """Those of `_slopes_of_responses` by poles, then by states."""
    return np.concatenate([_slopes_of_responses(v, at, lines) for v in (look.columns.poles, look.columns.local)])


def _products_of_slopes(slopes: Complex128, phi: Complex128, weight: Real, noise: Real) -> Real:
    """Products of the slopes by poles and states (parameters, outputs, lines) and of the columns phi / noise."""
    searched, outputs, n = len(slopes), len(noise), len(phi)
    weighted = slopes * weight
    matrix = np.zeros((searched + outputs * n,) * 2)
    matrix[:searched, :searched] = (weighted.reshape(searched, -1) @ slopes.reshape(searched, -1).conj().T).real
    cross = ((weighted @ phi.conj().T).real / noise[:, None]).reshape(searched, -1)
    matrix[:searched, searched:], matrix[searched:, :searched] = cross, cross.T
    for o in range(outputs):
        own = slice(searched + o * n, searched + (o + 1) * n)
        matrix[own, own] = ((phi * weight[o]) @ phi.conj().T).real / noise[o] ** 2
    return matrix


def _slopes_of_responses(vectors: DerivativeVectors, at: DrivenModel, lines: slice) -> Complex128:
    """(parameters, outputs, lines) of the responses, in noise units."""
    values = complex_lines(vectors.values)[:, lines]
    each = (at.coefficients / at.noise)[vectors.column][:, :, None] * values[:, None]
    starts = np.flatnonzero(np.diff(vectors.parameter, prepend=-1))
    return np.add.reduceat(each, starts, axis=0)


def _solve_damped(matrix: Real, gradient: Real, damping: float) -> Real:
    scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * np.outer(scale, scale) + damping * np.eye(len(scale))
    return scale * linalg.solve(scaled, scale * gradient, assume_a="sym")


def _step_model(at: DrivenModel, step: Real) -> DrivenModel:
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
