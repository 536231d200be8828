"""Hits that do not answer as the others at their point: a channel swapped, turned, late, or of another range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.plan import HitAcceptance
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
"""Of the difference, what an explanation may leave of it; of what a factor leaves, what a cut-off top may."""
TOP = 0.98
"""Of the largest force, from which on a sample may have been cut off."""
LATEST = 32
"""Samples by which a channel is looked for to be late or early."""
MOST_LOST = 64
"""Samples that a channel is looked for to have lost."""
_BEGUN = 0.02
"""Of the power of what differs, at which it has begun."""


@dataclass(frozen=True, eq=False, slots=True)
class _Point:
    """The hits at one point: what each makes of the usual force, on Re s = sigma.

    Attributes:
        hits: of it.
        values: (hits, outputs, lines) FRFs times the size of the usual force, so that lines count as they were driven.
        forces: (hits, lines) their spectra.
        strength: (hits,) of their forces, relative to the usual one.
        lines: indices of the lines.
        sigma: in 1/s.
    """

    hits: Sequence[Signals]
    values: Complex128
    forces: Complex128
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
    """The hits that answer as the others at their point, and a note on each that does not or that has two contacts.

    A structure gives the same FRFs to every hit at a point, but for the place and the force of the hit. Beside that
    stands a channel that differs alone or from a time on, or one of which a factor, a delay or another channel is what
    differs, or a force whose top is cut off.

    Args:
        signals: of an impact test.
    """
    notes: dict[str, str] = {}
    for group in group_by_point(signals):
        if len(group) >= LEAST_HITS and all(len(s.forces) == 1 for s in group):
            notes |= _odd_of(_point_of(group))
    kept = [s for s in signals if s.block.name not in notes]
    twice = (_second_contact(s) for s in kept if len(s.forces) == 1)
    return kept, (*notes.values(), *filter(None, twice))


def _second_contact(signals: Signals) -> str:
    """A note on the second contact of a hit; "" if it has none that a recorded hit would be rejected for."""
    contacts = np.split(signals.hit_force, [first for first, _ in signals.hit.pauses])
    second = max((float(part.max()) for part in contacts[1:]), default=0.0) / float(contacts[0].max())
    if second <= HitAcceptance().double_hit_ratio:
        return ""
    begins = signals.hit.pauses[0][1] / signals.rate_hz
    return (
        f"{signals.block.name}: the force has a second contact of {100 * second:.3g} % from {begins:.4g} s on; "
        "both are in the model."
    )


def _point_of(group: Sequence[Signals]) -> _Point:
    n, rate = group[0].force.size, group[0].rate_hz
    sigma, lines = float(np.log(LEAK) * rate / n), lines_of_band(n, rate, default_band([group]))
    window = np.exp(-sigma * np.arange(n) / rate)
    forces = np.stack([scipy.fft.rfft(s.hit_force * window)[lines] for s in group])
    motions = (s.responses - pre_trigger_level(s)[:, None] for s in group)
    responses = np.stack([scipy.fft.rfft(m * window, axis=-1)[:, lines] for m in motions])
    strength = _size(forces) / np.median(_size(forces))
    return _Point(group, responses / forces[:, None] * _size(forces.T)[None, None], forces, strength, lines, sigma)


def _size(values: Complex128) -> Real:
    return np.sqrt(np.mean(np.abs(values) ** 2, axis=-1))


def _odd_of(point: _Point) -> dict[str, str]:
    """By name of a hit, what of it differs."""
    found = {point.hits[k].block.name: _fault_of(point, k) for k in range(len(point.hits))}
    return {name: f"Left out, {name}: {what}." for name, what in found.items() if what}


def _fault_of(point: _Point, hit: int) -> str:
    """What differs in a hit from the others at its point; "" if nothing does."""
    own, usual = point.differences[hit], np.median(point.differences, axis=0)
    if (own > SPREAD * usual).all() and (more := _cut_off(point, hit)):
        return (
            f"its force is cut off at {point.hits[hit].hit_force.max():.4g} N: the responses ask for {more:.3g} N more"
        )
    odd = [int(k) for k in np.flatnonzero((own > ODD) & (own > SPREAD * usual))]
    if len(odd) == own.size and (found := _as_usual(point, hit, odd, odd)):
        return f"its force is {_in_words(1 / found[0], -found[1], 'it')}"
    if whole := "; ".join(filter(None, (_of_channel(point, hit, k) for k in odd))):
        return whole
    alone = [k for k in range(own.size) if own[k] > SPREAD * max(usual[k], np.delete(own, k).max(initial=0.0))]
    return _of_one(point, hit, alone[0], odd=alone == odd and own.size > 1) if len(alone) == 1 else ""


def _cut_off(point: _Point, hit: int) -> float:
    """What the force lacks at its top in N, if that is what differs in all responses; 0 if it is not.

    A factor of all responses is looked at beside it: in a band in which the hit is short, the two are the same.
    """
    force, differs = point.hits[hit].hit_force, point.values[hit] - point.usual
    top = np.flatnonzero(force > TOP * force.max()) / point.hits[hit].rate_hz
    s = point.sigma + 2j * np.pi * point.lines * point.hits[hit].rate_hz / force.size
    more, left = _explained(differs, point.usual * np.exp(-np.outer(top, s))[:, None] / point.forces[hit])
    _, of_factor = _explained(differs, point.usual[None])
    return float(more.max()) if more.sum() > 0 and left < EXPLAINED * min(of_factor, 1.0) else 0.0


def _explained(differs: Complex128, by: Complex128) -> tuple[Real, float]:
    """The factors (parts,) with which `by` (parts, ...) is most of what differs, and the share that it leaves."""
    parts, whole = by.reshape(len(by), -1).T, differs.ravel()
    a, b = np.concatenate([parts.real, parts.imag]), np.concatenate([whole.real, whole.imag])
    factors = np.asarray(np.linalg.lstsq(a, b, rcond=None)[0], np.float64)
    return factors, float(np.linalg.norm(b - a @ factors) / np.linalg.norm(b))


def _from_a_time_on(point: _Point, hit: int, channel: int) -> str:
    """What a channel is that is as usual up to a time: only noise from there on, or shifted as where samples are lost.

    "" if neither explains what differs.
    """
    signals, n = point.hits[hit], point.hits[hit].force.size
    spectra = np.zeros((2, n // 2 + 1), complex)
    spectra[:, point.lines] = np.stack([point.values[hit, channel], point.usual[channel]]) * point.forces[hit]
    window = np.exp(-point.sigma * np.arange(n) / signals.rate_hz)
    own, usual = scipy.fft.irfft(spectra, n) / window
    before = np.concatenate([[0.0], np.cumsum((window * (own - usual)) ** 2)])
    shifts = [k for k in range(-MOST_LOST, MOST_LOST + 1) if k]
    beside = [np.zeros(n), *(np.roll(usual, -k) for k in shifts)]
    left: list[Real] = [before + np.cumsum(np.r_[0.0, (window * (own - one))[::-1] ** 2])[::-1] for one in beside]
    which, at = np.unravel_index(int(np.argmin(left)), (len(left), n + 1))
    if left[int(which)][int(at)] > EXPLAINED**2 * before[-1]:
        return ""
    lost = shifts[int(which) - 1] if which else 0
    what = "holds only noise" if not lost else f"lacks {lost} samples" if lost > 0 else f"is {-lost} samples late"
    return f"{what} from {float(at) / signals.rate_hz:.4g} s on"


def _of_channel(point: _Point, hit: int, channel: int) -> str:
    names = point.hits[hit].outputs
    for other in sorted(range(len(names)), key=lambda k: k != channel):
        if found := _as_usual(point, hit, [channel], [other]):
            return f"channel {names[channel]} is {_in_words(*found, 'it' if other == channel else names[other])}"
    return ""


def _of_one(point: _Point, hit: int, channel: int, *, odd: bool) -> str:
    """What is wrong with the one channel that differs; "" if that is not known, and it is not `odd` either."""
    name = point.hits[hit].outputs[channel]
    if found := _from_a_time_on(point, hit, channel):
        return f"channel {name} {found}"
    first = _begins_at(point, hit, channel)
    found = f"channel {name} does not follow the force as in the other hits there, from {first:.4g} s on"
    return found if odd else ""


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
