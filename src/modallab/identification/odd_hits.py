"""Hits that do not answer as the others at their point: a channel swapped, turned, late, or of another range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.frf.estimate import group_by_point, lines_of_band, pre_trigger_level
from modallab.identification.impact import LEAK, default_band
from modallab.signals.signals import Signals

LEAST_HITS = 3
"""At a point: of two that differ either may be at fault."""
ODD = 0.1
"""Of an FRF's size, from which on a hit's differs from that of the others by a fault, not by its place or its force."""
SPREAD = 5.0
"""Times the usual difference at the point, above which a hit or a channel stands alone."""
EXPLAINED = 0.25
"""Of the difference, what a factor and a delay may leave of it."""
LATEST = 32
"""Samples by which a channel is looked for to be late or early."""
_BEGUN = 0.02
"""Of the power of what differs, at which it has begun."""


@dataclass(frozen=True, eq=False, slots=True)
class _Point:
    """The hits at one point: what each makes of the usual force, on Re s = sigma.

    Attributes:
        hits: of it.
        values: (hits, outputs, lines) FRFs times the size of the usual force, so that lines count as they were driven.
        strength: (hits,) of their forces, relative to the usual one.
        lines: indices of the lines.
        sigma: in 1/s.
    """

    hits: Sequence[Signals]
    values: Complex128
    strength: Real
    lines: NDArray[np.int64]
    sigma: float

    @property
    def usual(self) -> Complex128:
        """(outputs, lines) the median of the hits."""
        return np.median(self.values.real, axis=0) + 1j * np.median(self.values.imag, axis=0)

    @property
    def differences(self) -> Real:
        """(hits, outputs) from what is usual, relative to it; less of a soft hit, in which noise counts for more."""
        return np.minimum(self.strength, 1)[:, None] * _size(self.values - self.usual) / _size(self.usual)


def agreeing_hits(signals: Sequence[Signals]) -> tuple[list[Signals], tuple[str, ...]]:
    """The hits that answer as the others at their point, and a note on each that does not.

    A structure gives the same FRFs to every hit at a point, but for the place and the force of the hit. Beside that
    stands a channel that differs alone, or one of which a factor, a delay or another channel is what differs.

    Args:
        signals: of an impact test.
    """
    notes: dict[str, str] = {}
    for group in group_by_point(signals):
        if len(group) >= LEAST_HITS and all(len(s.forces) == 1 for s in group):
            notes |= _odd_of(_point_of(group))
    return [s for s in signals if s.block.name not in notes], tuple(notes.values())


def _point_of(group: Sequence[Signals]) -> _Point:
    n, rate = group[0].force.size, group[0].rate_hz
    sigma, lines = float(np.log(LEAK) * rate / n), lines_of_band(n, rate, default_band([group]))
    window = np.exp(-sigma * np.arange(n) / rate)
    forces = np.stack([scipy.fft.rfft(s.hit_force * window)[lines] for s in group])
    motions = (s.responses - pre_trigger_level(s)[:, None] for s in group)
    responses = np.stack([scipy.fft.rfft(m * window, axis=-1)[:, lines] for m in motions])
    strength = _size(forces) / np.median(_size(forces))
    return _Point(group, responses / forces[:, None] * _size(forces.T)[None, None], strength, lines, sigma)


def _size(values: Complex128) -> Real:
    return np.sqrt(np.mean(np.abs(values) ** 2, axis=-1))


def _odd_of(point: _Point) -> dict[str, str]:
    """By name of a hit, what of it differs."""
    found = {point.hits[k].block.name: _fault_of(point, k) for k in range(len(point.hits))}
    return {name: f"Left out, {name}: {what}." for name, what in found.items() if what}


def _fault_of(point: _Point, hit: int) -> str:
    """What differs in a hit from the others at its point; "" if nothing does."""
    own, usual = point.differences[hit], np.median(point.differences, axis=0)
    odd = [int(k) for k in np.flatnonzero((own > ODD) & (own > SPREAD * usual))]
    if len(odd) == own.size and (found := _as_usual(point, hit, odd, odd)):
        return f"its force is {_in_words(1 / found[0], -found[1], 'it')}"
    alone = own.size > 1 and len(odd) == 1 and own[odd[0]] > SPREAD * np.delete(own, odd).max()
    return "; ".join(filter(None, (_of_channel(point, hit, k, alone=alone) for k in odd)))


def _of_channel(point: _Point, hit: int, channel: int, *, alone: bool) -> str:
    names = point.hits[hit].outputs
    for other in sorted(range(len(names)), key=lambda k: k != channel):
        if found := _as_usual(point, hit, [channel], [other]):
            return f"channel {names[channel]} is {_in_words(*found, 'it' if other == channel else names[other])}"
    if not alone:
        return ""
    first = _begins_at(point, hit, channel)
    return f"channel {names[channel]} does not follow the force as in the other hits there, from {first:.4g} s on"


def _in_words(factor: float, late: int, what: str) -> str:
    when = f", and {abs(late)} samples {'late' if late > 0 else 'early'}" if late else ""
    return f"{factor:.3g} times what {what} is in the other hits there{when}"


def _as_usual(point: _Point, hit: int, rows: Sequence[int], others: Sequence[int]) -> tuple[float, int] | None:
    """The factor and the delay in samples that make the usual FRFs of `others` those of a hit in `rows`, if any do."""
    found, usual = point.values[hit, rows].ravel(), point.usual[others].ravel()
    delays, n = np.arange(-LATEST, LATEST + 1), point.hits[hit].force.size
    s = point.sigma + 2j * np.pi * np.tile(point.lines, len(rows)) * point.hits[hit].rate_hz / n
    turned = np.exp(-np.outer(delays / point.hits[hit].rate_hz, s))
    shares = (turned.conj() @ (usual.conj() * found)).real / (np.abs(turned[:, 0]) ** 2 * np.vdot(usual, usual).real)
    best = int((np.abs(shares) * np.abs(turned[:, 0])).argmax())
    left = _size(found - shares[best] * turned[best] * usual) / _size(found - point.usual[rows].ravel())
    return (float(shares[best]), int(delays[best])) if left < EXPLAINED else None


def _begins_at(point: _Point, hit: int, channel: int) -> float:
    """When a channel begins to differ, in s."""
    signals, n = point.hits[hit], point.hits[hit].force.size
    spectrum = np.zeros(n // 2 + 1, complex)
    # A taper over the band keeps apart in time what edges of the band would spread.
    spectrum[point.lines] = (point.values[hit, channel] - point.usual[channel]) * np.hanning(point.lines.size)
    beside = scipy.fft.irfft(spectrum, n) * np.exp(point.sigma * np.arange(n) / signals.rate_hz)
    power = np.cumsum(beside**2)
    # FRFs count time from the hit.
    return (signals.hit.peak + float(np.searchsorted(power, _BEGUN * power[-1]))) / signals.rate_hz
