"""How the reduced data answer small changes of the beam: every effect on it acts through poles and residues alone.

One evaluation of the kernels and of their slopes by the pole serves all free numbers; what a number does to the poles
and to the residues comes from the eigenvalue problem, which is far smaller than the data.

The chain rule through poles and residues; Fox and Kapoor, AIAA J. 6 (1968), 2426, give their derivatives in closed
form, here they are differences of two small eigenvalue problems.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.conditioning.reduce import ImpactData, Reduced, SineData
from modallab.gap.model.forward import (
    at_poles,
    impact_residual,
    impact_residue,
    on_clock,
    sine_drift,
    sine_residual,
    sine_residue,
    swapped,
)
from modallab.twin.bench import Chain, Twin, transfer
from modallab.twin.response import Hits, Sines
from modallab.twin.structure import Modes, Neighbours, Structure, alike, solve

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

SLOPE = 1e-6
"""Relative step of a pole for the slopes of the kernels."""


@dataclass(frozen=True, eq=False, slots=True)
class _Half:
    """Kernels of one of each conjugate pair of poles, and their slopes by the pole."""

    parts: tuple[Complex, ...]
    slopes: tuple[Complex, ...]
    chain: Complex
    chain_slope: Complex


class Tangent:
    """The answers of a twin on the data, and how they change with its structure, places and gains."""

    def __init__(self, twin: Twin, data: Reduced) -> None:
        """Evaluate the kernels of `twin` on `data`."""
        self.data, self.twin = data, twin
        modes = self._modes = solve(twin.structure)
        self._parts: list[_Hit | _Sine] = [_Hit(twin, modes, d, data) for d in data.impacts]
        if data.sines is not None:
            self._parts.append(_Sine(twin, _hung(twin, modes, data), data.sines, data))

    def changes(self, twins: Sequence[Twin], near: int = 0) -> list[Complex]:
        """(twins, channels, rows) each: what twins of nearly the same structure, places and gains add.

        Args:
            twins: the other twins.
            near: so many of them, the last, are solved to first order only.
        """
        first = len(twins) - near
        beside = Neighbours(self.twin.structure) if near else None
        modes = [self._solved(t.structure, beside if i >= first else None) for i, t in enumerate(twins)]
        found: list[Complex] = []
        for part in self._parts:
            own = modes if isinstance(part, _Hit) else self._all_hung(twins, modes, first)
            found.append(part.changes(twins, own))
        return found

    def _solved(self, structure: Structure, beside: Neighbours | None) -> Modes:
        if beside is None:
            return solve(structure)
        return self._modes if alike(structure, self.twin.structure) else beside.solve(structure)

    def _all_hung(self, twins: Sequence[Twin], modes: Sequence[Modes], first: int) -> list[Modes]:
        assert self.data.sines is not None
        x = self.data.sines.pieces[0].drive_x_m
        here, hung = self.twin.in_sine(x), [t.in_sine(x) for t in twins[first:]]
        if here is self.twin.structure and all(s is t.structure for s, t in zip(hung, twins[first:], strict=True)):
            near = list(modes[first:])
        else:
            same, beside = solve(here), Neighbours(here)
            near = [same if alike(s, here) else beside.solve(s) for s in hung]
        return [*(_hung(t, m, self.data) for t, m in zip(twins[:first], modes[:first], strict=True)), *near]


def _hung(twin: Twin, modes: Modes, data: Reduced) -> Modes:
    assert data.sines is not None
    structure = twin.in_sine(data.sines.pieces[0].drive_x_m)
    return modes if structure is twin.structure else solve(structure)


def _gains(chain: Chain, data: Reduced) -> Array:
    return np.array([chain.gain.get(c, 1.0) for c in data.channels]) / chain.force_gain


def _steps(here: tuple[Complex, Complex], there: list[tuple[Complex, Complex]]) -> tuple[Complex, Complex]:
    """Changes of the poles and of the residues, one row a twin."""
    return np.array([p for p, _ in there]) - here[0], np.array([r for _, r in there]) - here[1]


class _Hit:
    def __init__(self, twin: Twin, modes: Modes, d: ImpactData, data: Reduced) -> None:
        self.d, self.data, self.chain = d, data, twin.chain
        self.poles, self.residue = impact_residue(twin, modes, d, data)
        source = on_clock(d.source, twin)
        self.gains = _gains(twin.chain, data)
        self.on_lines = transfer(twin.chain, data.channels, source.s)
        self.halves = [self._half(source, p) for p in (self.poles, self.poles.conj())]
        pairs = zip(self.halves, (self.residue, self.residue.conj()), strict=True)
        self.static = self.on_lines * source.s**2
        self.residual = impact_residual(twin, modes, d, data)
        self.y = sum((self._answer(h, r) for h, r in pairs), self.residual[:, None] * self.static)

    def _half(self, source: Hits, poles: Complex) -> _Half:
        moved = poles * (1 + SLOPE)
        here, there = source.kernel(poles), source.kernel(moved)
        slopes = tuple((b - a) / (poles * SLOPE)[:, None] for a, b in zip(here, there, strict=True))
        chain = transfer(self.chain, self.data.channels, poles)
        return _Half(here, slopes, chain, (transfer(self.chain, self.data.channels, moved) - chain) / (poles * SLOPE))

    def _answer(self, half: _Half, r: Complex) -> Complex:
        forced, tail = half.parts
        return self.on_lines * (r @ forced) + (r * half.chain) @ tail

    def changes(self, twins: Sequence[Twin], modes: Sequence[Modes]) -> Complex:
        there = [impact_residue(t, m, self.d, self.data) for t, m in zip(twins, modes, strict=True)]
        dp, dr = _steps((self.poles, self.residue), there)
        residuals = np.array([impact_residual(t, m, self.d, self.data) for t, m in zip(twins, modes, strict=True)])
        total = _louder(self.gains, twins, self.data)[:, :, None] * self.y
        total = total + (residuals - self.residual)[:, :, None] * self.static
        for half, p, r, r0 in (
            (self.halves[0], dp, dr, self.residue),
            (self.halves[1], dp.conj(), dr.conj(), self.residue.conj()),
        ):
            turned = r0 * p[:, None, :]
            total = total + self._answer(half, r) + self.on_lines * (turned @ half.slopes[0])
            total += (turned * half.chain) @ half.slopes[1] + (turned * half.chain_slope) @ half.parts[1]
        return swapped(self.chain, self.data, total)


def _louder(gains: Array, twins: Sequence[Twin], data: Reduced) -> Array:
    """(twins, channels) relative change of the gains."""
    return np.array([_gains(t.chain, data) for t in twins]) / gains - 1


class _Sine:
    def __init__(self, twin: Twin, modes: Modes, d: SineData, data: Reduced) -> None:
        self.d, self.data, self.chain = d, data, twin.chain
        self.drift = sine_drift(twin, d, data)
        source = on_clock(d.source, twin)
        self.gains = _gains(twin.chain, data)
        self.at = tuple(transfer(twin.chain, data.channels, sign * source.drive) for sign in (1, -1))
        self.share = source.shares()
        self.poles, self.residue = sine_residue(twin, modes, d, data, self.drift)
        self.halves = [self._half(source, p) for p in (self.poles, self.poles.conj())]
        self.squared = source.drive**2
        self.residual = sine_residual(twin, modes, d, data, self.drift)
        still = np.zeros_like(self.poles)[None]
        self.y = self._total([(r[None], still) for r in (self.residue, self.residue.conj())], self.residual[None])[0]

    def _kernel(self, source: Sines, poles: Complex) -> tuple[Complex, ...]:
        up, down, decay = source.kernel(poles)
        if self.drift is not None:
            up, down, decay = up / self.drift, down / self.drift, decay / self.drift
        return up, down, decay, source.decay_shape(poles)

    def _half(self, source: Sines, poles: Complex) -> _Half:
        moved = poles * (1 + SLOPE)
        here, there = self._kernel(source, poles), self._kernel(source, moved)
        step = (poles * SLOPE) if poles.ndim == 2 else (poles * SLOPE)[:, None]
        slopes = tuple((b - a) / (step[..., None] if a.ndim == 3 else step) for a, b in zip(here, there, strict=True))
        chain, later = (at_poles(self.chain, self.data, p) for p in (poles, moved))
        return _Half(here, slopes, chain, (later - chain) / step)

    def changes(self, twins: Sequence[Twin], modes: Sequence[Modes]) -> Complex:
        there = [sine_residue(t, m, self.d, self.data, self.drift) for t, m in zip(twins, modes, strict=True)]
        dp, dr = _steps((self.poles, self.residue), there)
        residuals = [sine_residual(t, m, self.d, self.data, self.drift) for t, m in zip(twins, modes, strict=True)]
        change = self._total([(dr, dp), (dr.conj(), dp.conj())], np.array(residuals) - self.residual)
        change = change + _louder(self.gains, twins, self.data)[:, :, None, None] * self.y
        return swapped(self.chain, self.data, change.reshape(*change.shape[:2], -1))

    def _total(self, steps: list[tuple[Complex, Complex]], residual: Array) -> Complex:
        """(twins, channels, blocks, lines) of changes of residue, pole and (twins, channels, blocks) remainder."""
        count, channels = steps[0][0].shape[:2]
        blocks, lines = self.share[0].shape
        up = residual * self.squared
        down, rings = up, np.zeros((blocks, count * channels, lines), dtype=np.complex128)
        for half, (dr, dp), r0 in zip(self.halves, steps, (self.residue, self.residue.conj()), strict=True):
            a, b, decay, wave = half.parts
            da, db, ddecay, dwave = half.slopes
            step = (dp if dp.ndim == 3 else dp[:, :, None])[:, None]
            still = r0[:, :, None] * step
            up, down = up + _along(dr, still, a, da), down + _along(dr, still, b, db)
            swing = decay * half.chain
            amplitude = dr[..., None] * swing + still * (ddecay * half.chain + decay * half.chain_slope)
            rings += _rings(amplitude, wave) + _rings(still * swing, dwave)
        ringing = np.moveaxis(rings, 0, 1).reshape(count, channels, blocks, lines)
        return ringing + (up * self.at[0])[..., None] * self.share[0] + (down * self.at[1])[..., None] * self.share[1]


def _along(dr: Complex, still: Complex, kernel: Complex, slope: Complex) -> Complex:
    """(twins, channels, blocks) of changes of residue and of pole."""
    moved = dr @ kernel
    if still.shape[-1] == 1:
        return moved + still[..., 0] @ slope
    return moved + np.einsum("tcpb,pb->tcb", still, slope)


def _rings(amplitude: Complex, wave: Complex) -> Complex:
    """Sum over p of (twins, channels, p, blocks) times (p, blocks, lines): (blocks, twins x channels, lines)."""
    rows = amplitude.reshape(-1, *amplitude.shape[2:])
    return rows.transpose(2, 0, 1) @ wave.transpose(1, 0, 2)


def smooth_in(twin: Twin, other: Twin) -> bool:
    """Whether two twins differ in no more than structure, places and gains, and answer in proportion."""
    if twin.element is not None or other.element is not None:
        return False
    chain = replace(other.chain, gain=twin.chain.gain, shift=twin.chain.shift, force_gain=twin.chain.force_gain)
    fields = ("corner_hz", "mounts", "delay_s", "skew_s", "swap")
    alike = all(getattr(chain, f) == getattr(twin.chain, f) for f in fields)
    return alike and all(getattr(twin, f) == getattr(other, f) for f in ("ei_drift", "drift_curve", "clock"))
