"""What is left of a measured structure when a part of it, known by itself, is taken away at one joint.

The direct formula subtracts two receptances at the joint. Wherever the part is softer there than the rest, they are
nearly equal: each antiresonance of the part becomes two poles that no structure has. So the rest is fitted instead,
where nothing cancels. At a pole s of both, shape psi, the part takes the force -psi_c / H_part(s), hence
H_rest,xc(s) = -H_part(s) psi_x / psi_c. At a pole of the part alone it takes none, hence H_rest,xc(s) = H_both,xc(s).
Fitted are common poles and residues, by variable projection (Golub, Pereyra, Inverse Problems 19 (2003), R1) in
generalised least squares. Errors of a sensitivity are common to all poles: samples of both models give their
covariance.

One joint holds two structures together by one condition, so that between two neighbouring poles of both there is one
of the part or one of the rest (Golub, SIAM Review 15 (1973), 318, of a change of rank one). Each pole of the rest is
looked for in its own interval: free ones were lost to errors of a single value.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import least_squares

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.modification.outside_band import complete_residual_terms
from modallab.modification.structure import Structure, squared_shape_sum


@dataclass(frozen=True, slots=True)
class RemainderSettings:
    """Settings of what is left when a measured part is taken away.

    Attributes:
        powers: of s in the residual terms of what is left: what lies below and above the band, and the next one.
            Without the last, the worst FRAC of three pairs of plates was 0.86, with it 0.97; one more changed nothing.
        common: directions in which errors of all values go together, such as that of a sensitivity. With as many as
            the samples have, 61 to 67 % of those plates' frequencies lay in their 95 % interval; with these 72 to 83 %.
        own: of the variance of a value, a pure number: what at least it has for itself. Without any the covariance of
            a few samples is singular.
        widest: deviations of a sample that count. Beyond, a shape goes through zero at the joint, and its sample is off
            by any amount: without a bound the worst FRAC of those plates was 0.90.
        far: by which factor a pole may lie beyond all of both. It then stands for what is out of the band; a wider
            bound gave the same in six times the time.
        steps: of the search that follows, at most. Without a bound the same came out in three times the time.
    """

    powers: tuple[int, ...] = (-2, 0, 2)
    common: int = 20
    own: float = 0.01
    widest: float = 3.0
    far: float = 10.0
    steps: int = 50


DEFAULT = RemainderSettings()


LOOKED_AT = 200
"""Frequencies in each interval, to begin with."""
ROUNDING = float(np.sqrt(np.finfo(float).eps))
"""Of a value: what its deviation at least is, where models are given without any."""


def remainder_of_structure(
    both: Structure, samples: Structure, part: Structure, varied: Structure, at: Real, of: Real
) -> "RemainingStructure":
    """The structure without the part.

    Args:
        both: as measured, with the part.
        samples: (samples, ...) of it.
        part: by itself.
        varied: (samples, ...) of it.
        at: (freedoms, 1) the joint on the structure.
        of: (freedoms, 1) the joint on the part.

    Raises:
        DataError: the part has as many modes as both together.
    """
    within = pole_intervals_of_remainder(both, part)
    if not len(within):
        raise DataError(
            f"{len(part.poles)} modes of the part are more than leave any of {len(both.poles)}",
            remedy="identify both in the same band",
        )
    s, values = known_receptances(both, part, at, of)
    places, varied_values = known_receptances(samples, varied, at, of)
    off = varied_values - values
    rest = _fit_remainder(s, values, off, _start_poles(within, both, part, at, of), within, both, at)
    # Poles of the samples are off as well, and with them where values are known.
    left = off - rest.receptance_of_joint(places, at) + rest.receptance_of_joint(s, at)
    return _fit_remainder(s, values, left, rest.structure.poles, within, both, at)


def pole_intervals_of_remainder(both: Structure, part: Structure) -> Real:
    """(poles, 2) rad/s between which each pole of the rest lies: neighbouring poles of both with none of the part."""
    own, taken = np.sort(both.poles.imag), part.poles.imag
    ends = np.concatenate([[0.0], own, [np.inf]])
    between = np.stack([ends[:-1], ends[1:]], axis=1)
    alone = ~np.any((taken > between[:, :1]) & (taken <= between[:, 1:]), axis=1)
    # A structure that moves freely has its lowest pole at 0, which the term in s^-2 is.
    alone[0] &= not np.any(both.residual[..., np.array(both.powers) == -2, :, :])
    return np.clip(between[alone], own[0] / DEFAULT.far, own[-1] * DEFAULT.far)


def _start_poles(within: Real, both: Structure, part: Structure, at: Real, of: Real) -> Complex:
    """(poles,) where the direct formula, which is wrong by much at single frequencies, is largest in each interval."""
    omega = np.geomspace(within[:, 0], within[:, 1], LOOKED_AT + 2)[1:-1]
    own, taken = (one.receptance(1j * omega.ravel(), b, b).reshape(omega.shape) for one, b in ((both, at), (part, of)))
    # Where both answer alike the formula has no largest value; rounding bounds it.
    apart = np.abs(taken - own) + ROUNDING**2 * (np.abs(own) + np.abs(taken)) + np.finfo(float).tiny
    largest = np.argmax(np.abs(own) / apart * np.abs(taken), axis=0)
    damped = float(np.median(-both.poles.real / both.poles.imag))
    return omega[largest, np.arange(len(within))] * (1j - damped)


def _fit_remainder(
    s: Complex, values: Complex, off: Complex, start: Complex, within: Real, both: Structure, at: Real
) -> "RemainingStructure":
    """The rest by values and samples of what they are off by."""
    # Half of the samples weigh, the others tell what that leaves: else deviations come out too small.
    fit = CommonPoleFit(s, values, CorrelatedErrors.of(off[::2], values))
    return fit.structure_with_samples(fit.poles(start, within), within, both, at, off[1::2])


def known_receptances(both: Structure, part: Structure, at: Real, of: Real) -> tuple[Complex, Complex]:
    """(points,) where the receptances from the joint to all freedoms are known, and (..., points, freedoms) these."""
    at_poles = part.receptance(both.poles, of, of)[..., 0] / (both.psi @ at)
    shapes = -at_poles * both.psi
    alone = both.receptance(part.poles, None, at)[..., 0]
    return np.concatenate([both.poles, part.poles], axis=-1), np.concatenate([shapes, alone], axis=-2)


@dataclass(frozen=True, eq=False, slots=True)
class CorrelatedErrors:
    """Deviations of all values, real parts first, and the factor of their correlation.

    Attributes:
        scale: (points, freedoms) one deviation.
        factor: lower triangle of the correlation's Cholesky factors.
    """

    scale: Real
    factor: Real

    @classmethod
    def of(cls, off: Complex, values: Complex) -> "CorrelatedErrors":
        """From samples (samples, points, freedoms) of what values are off by."""
        # A median: near a node at the joint a few samples are off by any amount.
        scale = np.sqrt(np.median(np.abs(off) ** 2, axis=0) / (2 * np.log(2))) + ROUNDING * np.abs(values)
        each = np.clip(_flat_real(off / scale), -DEFAULT.widest, DEFAULT.widest) / np.sqrt(len(off))
        _, size, directions = np.linalg.svd(each, full_matrices=False)
        common = directions[: DEFAULT.common].T * size[: DEFAULT.common]
        own = np.maximum(1 - np.sum(common**2, axis=1), DEFAULT.own)
        return cls(scale, np.linalg.cholesky(common @ common.T + np.diag(own)))

    def whitened(self, values: Complex) -> Real:
        """(2 points freedoms, ...) of values (..., points, freedoms), uncorrelated and of unit variance."""
        return np.asarray(solve_triangular(self.factor, _flat_real(values / self.scale).T, lower=True))


def _flat_real(values: Complex) -> Real:
    parts = np.stack([values.real, values.imag], axis=-3)
    return np.asarray(parts.reshape(*parts.shape[:-3], -1), np.float64)


def pole_basis(s: Complex, poles: Complex, powers: tuple[int, ...]) -> Complex:
    """(points, 2 poles + terms): of real and imaginary parts of residues, and of residual terms over the highest."""
    up, down = 1 / (s[:, None] - poles), 1 / (s[:, None] - poles.conj())
    terms = [(s[:, None] / np.abs(s).max()) ** power for power in powers]
    return np.concatenate([up + down, 1j * (up - down), *terms], axis=1)


class CommonPoleFit:
    """Receptances from the joint by common poles, in generalised least squares."""

    def __init__(self, s: Complex, values: Complex, errors: CorrelatedErrors) -> None:
        self.s, self.values, self.errors = s, values, errors
        self.right = errors.whitened(values)

    def poles(self, start: Complex, within: Real) -> Complex:
        """(poles,) that fit best, each within its interval (poles, 2)."""
        low, high = _bounds(within)
        x = np.clip(_numbers_of_poles(start), low, high)
        found = least_squares(self._misfit, x, self._slopes, (low, high), x_scale="jac", max_nfev=DEFAULT.steps).x
        return _poles_of_numbers(found)

    def _columns(self, columns: Complex) -> Real:
        """Whitened (values, freedoms columns): each freedom has coefficients of its own."""
        freedoms = self.values.shape[1]
        each = np.einsum("pc,fg->fcpg", columns, np.eye(freedoms))
        return self.errors.whitened(each.reshape(-1, *self.values.shape))

    def _solved(self, poles: Complex) -> tuple[Real, Real]:
        """Orthonormal columns of the basis, and (freedoms, terms) coefficients."""
        columns = self._columns(pole_basis(self.s, poles, DEFAULT.powers))
        q, r = np.linalg.qr(columns)
        found = np.linalg.lstsq(r, q.T @ self.right, rcond=None)[0]
        return np.asarray(q, np.float64), np.asarray(found.reshape(self.values.shape[1], -1), np.float64)

    def _misfit(self, x: Real) -> Real:
        q, _ = self._solved(_poles_of_numbers(x))
        return np.asarray(self.right - q @ (q.T @ self.right))

    def _slopes(self, x: Real) -> Real:
        poles = _poles_of_numbers(x)
        q, found = self._solved(poles)
        columns = self.errors.whitened(self._moves(poles, found))
        return np.asarray(-(columns - q @ (q.T @ columns)))

    def _moves(self, poles: Complex, found: Real) -> Complex:
        """(numbers, points, freedoms) of the values with log frequency, then with damping, of each pole."""
        n = len(poles)
        residues = (found[:, :n] + 1j * found[:, n : 2 * n]).T
        up = residues[:, None] / ((self.s - poles[:, None]) ** 2)[..., None]
        down = residues.conj()[:, None] / ((self.s - poles.conj()[:, None]) ** 2)[..., None]
        along = np.concatenate([poles, -poles.imag])
        double = np.concatenate([up, up]), np.concatenate([down, down])
        return double[0] * along[:, None, None] + double[1] * along.conj()[:, None, None]

    def structure_with_samples(
        self, poles: Complex, within: Real, both: Structure, at: Real, off: Complex
    ) -> "RemainingStructure":
        """The structure of these poles, with samples of it."""
        q, found = self._solved(poles)
        x = _numbers_of_poles(poles)
        slopes = self.errors.whitened(self._moves(poles, found))
        whole = np.column_stack([self._columns(pole_basis(self.s, poles, DEFAULT.powers)), slopes])
        left = self.right - q @ (q.T @ self.right)
        misfit = float(left @ left) / max(1, len(left) - whole.shape[1])
        moved = (np.linalg.pinv(whole) @ self.errors.whitened(off)).T * np.sqrt(max(1.0, misfit))
        linear = found.reshape(-1) + moved[:, : found.size]
        varied = np.array([_poles_of_numbers(one) for one in np.clip(x + moved[:, found.size :], *_bounds(within))])
        highest = float(np.abs(self.s).max())
        return RemainingStructure(
            _samples_of_structure(both, at, poles[None], found[None], highest).one_sample(0),
            _samples_of_structure(both, at, varied, linear.reshape(-1, *found.shape), highest),
        )


@dataclass(frozen=True, eq=False, slots=True)
class RemainingStructure:
    """What is left.

    Attributes:
        structure: of it.
        samples: (samples, ...) of it.
    """

    structure: Structure
    samples: Structure

    def receptance_of_joint(self, s: Complex, at: Real) -> Complex:
        """(..., points, freedoms) receptances from the joint."""
        return self.structure.receptance(s, None, at)[..., 0]


def _numbers_of_poles(poles: Complex) -> Real:
    """Log frequency and damping of each pole."""
    return np.concatenate([np.log(poles.imag), -poles.real / poles.imag])


def _bounds(within: Real) -> tuple[Real, Real]:
    """Of the numbers of poles that lie within intervals (poles, 2)."""
    return np.append(np.log(within[:, 0]), np.zeros(len(within))), np.append(np.log(within[:, 1]), np.ones(len(within)))


def _poles_of_numbers(x: Real) -> Complex:
    half = len(x) // 2
    return np.exp(x[:half]) * (-x[half:] + 1j)


def _samples_of_structure(both: Structure, at: Real, poles: Complex, found: Real, highest: float) -> Structure:
    """Samples of a structure by poles (samples, poles) and coefficients (samples, freedoms, terms)."""
    n, joint = poles.shape[-1], int(np.argmax(at[:, 0]))
    residue = (found[..., :n] + 1j * found[..., n : 2 * n]).swapaxes(-1, -2)
    psi = residue / np.sqrt(residue[..., joint])[..., None]
    terms = found[..., 2 * n :].swapaxes(-1, -2) / highest ** np.array(DEFAULT.powers, np.float64)[:, None]
    every, high_hz = range(len(both.freedoms)), both.band_hz[1]
    whole = [
        complete_residual_terms(t[..., None], DEFAULT.powers, every, [joint], squared_shape_sum(p, q), high_hz)
        for t, p, q in zip(terms, poles, psi, strict=True)
    ]
    residual, alone = np.array([w.terms for w in whole]), np.mean([w.alone for w in whole], axis=0)
    known = np.zeros_like(both.known)
    known[joint] = known[:, joint] = True
    return replace(both, poles=poles, psi=psi, powers=DEFAULT.powers, residual=residual, alone=alone, known=known)
