"""Poles and modal constants of the hits, identified without a model of the beam.

The response to a hit is linear in the modal constants and smooth in the poles: the constants are projected out, and the
poles refined by Gauss-Newton steps (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973, 413).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.ring_down_poles import ring_down_poles
from modallab.gap.conditioning.rows import ImpactData, Reduced

Array = NDArray[np.float64]

UNIT = 1e-2
"""Step of a pole's logarithm and angle that is one in the search: the usual size of a first error."""
SOFT = 0.02
"""Relative error of a superposition of the modes in the band: the modes above it are one term only."""
ABOVE_BAND = 1.65
"""Frequency of the term for the modes above, over that of the last pole: the next mode of a beam, about."""
LEAST_DAMPING, MOST_DOUBT, APART, ONE_CHANNEL = 3e-4, 0.15, 1.05, 0.9
"""A pole is kept with at least this damping ratio, at most this relative deviation of its constants, at least this far
from the one before, and at most this share of its power on one of several channels: more is a mount's."""
SEVERAL = 3
"""Channels from which shares of a mode's power tell a mount from a beam: two may lie near the root and the tip."""


@dataclass(frozen=True, eq=False, slots=True)
class PointModes:
    """What the hits at one point show.

    Attributes:
        data: the hits.
        poles: (p,) in rad/s, sorted.
        log_sigma: (p,) standard deviation of log |pole|.
        angle_sigma: (p,) of the pole's angle, rad.
        constants: (channels, p) modal constants (residues of displacement per force, with the channel's gain); NaN
            where the channel is not to be used.
        constant_sigma: (channels, p) standard deviation of each part; inf where not to be used.
    """

    data: ImpactData
    poles: Complex
    log_sigma: Array
    angle_sigma: Array
    constants: Complex
    constant_sigma: Array

    @property
    def damping(self) -> Array:
        """(p,) damping ratios."""
        return -self.poles.real / np.abs(self.poles)

    def where_used(self, constants: Complex) -> Complex:
        """(channels, p) modal constants, 0 where they are not to be used."""
        kept: Complex = np.zeros(constants.shape, np.complex128)
        np.copyto(kept, constants, where=np.isfinite(self.constant_sigma))
        return kept

    def kept(self, keep: NDArray[np.bool_]) -> "PointModes":
        """The same with some of the poles only."""
        return replace(
            self,
            poles=self.poles[keep],
            log_sigma=self.log_sigma[keep],
            angle_sigma=self.angle_sigma[keep],
            constants=self.constants[:, keep],
            constant_sigma=self.constant_sigma[:, keep],
        )


def identify_hit_modes(
    data: Reduced, hits: Sequence[Block], channels: Sequence[int], top_hz: float, driven: Complex
) -> tuple[PointModes, ...]:
    """The modes at each drive point; those of all points are looked for at each.

    Args:
        data: the reduced records.
        hits: the records it was made of.
        channels: indices into its channels that may be used for the poles.
        top_hz: end of the band.
        driven: poles that records of a drive show.
    """
    within = driven[np.abs(driven) < 2 * np.pi * top_hz]
    first = [
        within if d.piece.by_shaker else _starting_poles(d, hits, data.rig, channels, top_hz) for d in data.impacts
    ]
    whole = _distinct(np.concatenate([*first, np.zeros(0, complex)]))
    found: list[PointModes] = []
    for d, own in zip(data.impacts, first, strict=True):
        begin = np.array([min([*own, p], key=lambda q: abs(np.log(abs(q) / abs(p)))) for p in whole], complex)
        point = _modes_of_point(d, begin)
        if point is not None:
            found.append(point)
    return tuple(found)


def identify_again(points: Sequence[PointModes], data: Reduced) -> tuple[PointModes, ...]:
    """The modes of other records of the same hits, the search begun at the poles that are known."""
    poles = {p.data.piece.name: p.poles for p in points}
    found = (_modes_of_point(d, poles[d.piece.name]) for d in data.impacts if d.piece.name in poles)
    return tuple(p for p in found if p is not None)


def _starting_poles(d: ImpactData, hits: Sequence[Block], rig: Rig, channels: Sequence[int], top_hz: float) -> Complex:
    """Poles of the ring-down of one hit, where the search begins."""
    own = [b for b in hits if b.name in d.piece.records]
    poles = ring_down_poles(own[len(own) // 2 :][:1], rig, channels, top_hz)
    return _distinct(poles[-poles.real / np.abs(poles) > LEAST_DAMPING])


def _distinct(poles: Complex) -> Complex:
    """Poles sorted by frequency without those next to the one before."""
    found: list[complex] = []
    for p in poles[np.argsort(np.abs(poles))].tolist():
        if not found or abs(p) > APART * abs(found[-1]):
            found.append(p)
    return np.array(found, dtype=np.complex128)


def _modes_of_point(d: ImpactData, poles: Complex) -> PointModes | None:
    point = None
    for _ in range(2):
        if not len(poles):
            return None
        point = _refined_poles(d, poles)
        sure = _well_determined(point)
        if np.all(sure):
            break
        poles = point.poles[sure]
    if point is None:
        return None
    point = point.kept(_well_determined(point) & _bending_modes(point))
    return point if len(point.poles) else None


def _well_determined(point: PointModes) -> NDArray[np.bool_]:
    size = np.sqrt(np.nanmean(np.abs(point.constants) ** 2, axis=0))
    return (np.median(point.constant_sigma, axis=0) < MOST_DOUBT * size) & (point.damping > LEAST_DAMPING)


def _bending_modes(point: PointModes) -> NDArray[np.bool_]:
    power = np.nan_to_num(np.abs(point.constants) ** 2)
    if np.count_nonzero(np.any(power, axis=1)) < SEVERAL:
        return np.ones(power.shape[1], bool)
    return power.max(axis=0) < ONE_CHANNEL * np.maximum(power.sum(axis=0), 1e-300)


class _Projection:
    """The lines of the hits at one point in the band, the modal constants projected out."""

    def __init__(self, d: ImpactData, top: float) -> None:
        keep = d.source.lines / (d.source.n * d.source.dt) < top
        self.source = d.source.on_lines(keep)
        y, sigma = d.rows.y[:, keep], d.rows.sigma[:, keep]
        self.used = np.all(np.isfinite(sigma), axis=1)
        y, sigma = y[self.used], sigma[self.used]
        rms = np.sqrt(np.mean(np.abs(y) ** 2, axis=1, keepdims=True))
        weight = 1 / np.hypot(sigma, SOFT * np.maximum(np.abs(y), 0.3 * rms))
        self.weight = np.concatenate([weight, weight], axis=1)
        self.y = np.concatenate([y.real, y.imag], axis=1) * self.weight

    def solve(self, poles: Complex) -> tuple[Array, Array, Array]:
        """(channels, terms) least-squares amplitudes, (channels, 2 lines) residual, (channels, terms) deviations."""
        basis = self._basis(poles)
        A = np.concatenate([basis.real, basis.imag], axis=1).T
        scale = np.linalg.norm(A, axis=0)
        q, r = np.linalg.qr(A / scale * self.weight[:, :, None])
        inverse = np.linalg.pinv(r, rcond=1e-12)
        along = np.einsum("cbk,cb->ck", q, self.y)
        x = np.einsum("ckj,cj->ck", inverse, along)
        rest = self.y - np.einsum("cbk,ck->cb", q, np.einsum("ckj,cj->ck", r, x))
        return x / scale, rest, np.sqrt(np.sum(inverse**2, axis=2)) / scale

    def _basis(self, poles: Complex) -> Complex:
        """(2 p + 2, lines): real and imaginary parts of the modal constants, mass line, modes above the band."""
        up, down = (np.sum(self.source.response_to_unit_residue(p), axis=0) for p in (poles, poles.conj()))
        s, top = self.source.s, np.abs(poles[-1])
        above = s**2 * top**2 / (s**2 + (ABOVE_BAND * top) ** 2)
        return np.array([*(up + down), *(1j * (up - down)), s**2, above])


def _refined_poles(d: ImpactData, poles: Complex, steps: int = 6) -> PointModes:
    """The poles after Gauss-Newton steps from those given, with their modal constants."""
    lines, n = _Projection(d, 1.2 * abs(poles[-1]) / (2 * np.pi)), len(poles)

    def moved(v: Array) -> Complex:
        return poles * np.exp(UNIT * (v[:n] + 1j * v[n:]))

    v, damping = np.zeros(2 * n), 1e-3
    x, r, sigma = lines.solve(poles)
    normal = np.eye(2 * n)
    for _ in range(steps):
        J = np.array([(lines.solve(moved(v + e))[1] - r).ravel() / 1e-4 for e in 1e-4 * np.eye(2 * n)]).T
        normal, gradient, before = J.T @ J, J.T @ r.ravel(), float(np.sum(r**2))
        for _ in range(5):
            there = v - np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-9), gradient)
            if np.max(np.abs(there)) < 20 and np.all(moved(there).real < 0):
                trial = lines.solve(moved(there))
                if np.sum(trial[1] ** 2) < before:
                    (x, r, sigma), v, damping = trial, there, damping / 10
                    break
            damping *= 10
        if before - np.sum(r**2) < 1e-3 * before:
            break
    return _point_modes(d, lines, moved(v), (x, r, sigma), normal)


def _point_modes(
    d: ImpactData, lines: _Projection, poles: Complex, solved: tuple[Array, Array, Array], normal: Array
) -> PointModes:
    (x, r, sigma), n = solved, len(poles)
    # What superposition leaves, more or less than the weights say, is the noise.
    worse = float(np.sqrt(np.mean(r**2)))
    deviation = np.sqrt(np.maximum(np.diag(np.linalg.pinv(normal)), 0)) * worse * UNIT
    constants = np.full((len(d.rows.y), n), np.nan, dtype=np.complex128)
    constant_sigma = np.full((len(d.rows.y), n), np.inf)
    constants[lines.used] = x[:, :n] + 1j * x[:, n : 2 * n]
    constant_sigma[lines.used] = np.maximum(sigma[:, :n], sigma[:, n : 2 * n]) * worse
    order = np.argsort(np.abs(poles))
    found = PointModes(d, poles, deviation[:n], deviation[n:], constants, constant_sigma)
    return replace(
        found,
        poles=poles[order],
        log_sigma=found.log_sigma[order],
        angle_sigma=found.angle_sigma[order],
        constants=constants[:, order],
        constant_sigma=constant_sigma[:, order],
    )
