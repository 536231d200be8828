"""Where the hit lies in an impact block, and the force with everything else set to zero."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.signals.checks import check_positive, check_rows

BESIDE, FAR = 2.5, 8.0
"""In sigmas of the noise: what a neighbour of a contact's sample reaches, and from where on it needs none."""
LEAST_PAUSE, APART = 16, 4
"""Samples between two contacts, and how many times as long as a contact what lies between them is."""
LOW_RMS = 0.789
"""Rms of the nine tenths of a standard normal variable that are smallest: sqrt(1 - 2 z p(z) / 0.9), z = 1.645."""


@dataclass(frozen=True, slots=True)
class HitSamples:
    """Where the contacts of a hit lie in a force.

    Attributes:
        first: the first sample of the first contact.
        stop: behind the last of the last contact.
        peak: the largest sample.
        offset: the channel's level outside, in N.
        noise: its standard deviation there, in N.
        pauses: first samples and those behind the last of what lies between contacts, in which no force acts.
    """

    first: int
    stop: int
    peak: int
    offset: float
    noise: float
    pauses: tuple[tuple[int, int], ...] = ()


def find_hit(force: NDArray[np.float64], threshold: float = 5.0) -> HitSamples:
    """The stretch about the peak beyond which force is noise only.

    Args:
        force: (n,) N.
        threshold: how many noise sigmas belong to the hit.

    Raises:
        DataError: no sample stands out of the noise, or the force is not one record.
    """
    check_rows(force, "force")
    check_positive(threshold, "the threshold in sigmas")
    if force.ndim != 1:
        raise DataError(f"the force has shape {force.shape}", remedy="give the force channel alone, (n,)")
    peak = int(np.argmax(np.abs(force)))
    offset = float(np.median(force))
    level = np.abs(force - offset)
    noise = _noise_of_force(force, level)
    loud = _contact_samples(force - offset, max(threshold * noise, 1e-3 * level[peak]), noise)
    if level[peak] < 2 * threshold * noise or loud.size == 0:
        raise DataError(
            f"no hit: the force peaks at {level[peak]:.3g} N over a noise of {noise:.3g} N",
            remedy="leave this record out, or identify it as a sine test",
        )
    contacts = _contacts(loud)
    margins = [max(4, (last - first) // 2) for first, last in contacts]
    spans = [(max(0, a - m), min(len(force), b + m + 1)) for (a, b), m in zip(contacts, margins, strict=True)]
    first, stop, pauses = spans[0][0], spans[-1][1], tuple((a[1], b[0]) for a, b in pairwise(spans))
    outside = np.concatenate([force[:first], force[stop:]])
    if outside.size < 16:
        return HitSamples(first, stop, peak, offset, noise, pauses)
    # A median of few counts is coarse; the samples outside the hit give offset and noise.
    return HitSamples(first, stop, peak, float(outside.mean()), float(outside.std()), pauses)


def _contacts(loud: NDArray[np.int64]) -> list[tuple[int, int]]:
    """First and last sample of each contact: what is apart by more than `APART` times the longest is another.

    The ringing of a steep filter is part of the contact that it follows.
    """
    gaps = np.flatnonzero(np.diff(loud) > LEAST_PAUSE)
    firsts, lasts = np.r_[loud[0], loud[gaps + 1]], np.r_[loud[gaps], loud[-1]]
    longest = int((lasts - firsts).max()) + 1
    apart = np.flatnonzero(firsts[1:] - lasts[:-1] > APART * longest)
    return [
        (int(a), int(b))
        for a, b in zip(np.r_[firsts[0], firsts[apart + 1]], np.r_[lasts[apart], lasts[-1]], strict=True)
    ]


def _noise_of_force(force: NDArray[np.float64], level: NDArray[np.float64]) -> float:
    """Standard deviation of the noise in a force of which most is noise alone, hit or not.

    The median of the magnitudes; where that is less than a step of the converter, the rms of the lower nine tenths over
    what that is of a normal variable's, and at least that of rounding.
    """
    median = float(np.median(level))
    values = np.unique(force)
    step = float(np.min(np.diff(values))) if values.size > 1 else 0.0
    if median > step / 2:
        return 1.4826 * median
    low = np.sort(level)[: int(0.9 * level.size)]
    return float(max(np.sqrt(np.mean(low**2)) / LOW_RMS, step / np.sqrt(12)))


def _contact_samples(force: NDArray[np.float64], least: float, noise: float) -> NDArray[np.int64]:
    """Indices of the samples that belong to a contact: above `least`, and not alone.

    Of thousands of samples one may stand five sigmas out of the noise by chance, and would make the hit last up to it.
    It has no neighbour that leans to its side; a contact has, or stands out far more.
    """
    level, side = np.abs(force), np.sign(force)
    beside = np.maximum(side * np.roll(force, 1), side * np.roll(force, -1))
    return np.flatnonzero((level > least) & ((beside > BESIDE * noise) | (level > FAR * noise)))


def windowed_force(force: NDArray[np.float64], hit: HitSamples) -> NDArray[np.float64]:
    """The force with its offset taken off and zero outside the hit.

    The force channel's noise would otherwise ring through every lightly damped mode of a predicted response.

    Raises:
        DataError: the force is not one record, or not one that this hit can be of.
    """
    check_rows(force, "force")
    if force.ndim != 1 or not 0 <= hit.first < hit.stop <= force.size:
        found = f"a hit from sample {hit.first} to {hit.stop} is not in a force of shape {force.shape}"
        raise DataError(found, remedy="give the force in which the hit was found")
    windowed = np.zeros_like(force)
    windowed[hit.first : hit.stop] = force[hit.first : hit.stop] - hit.offset
    for first, stop in hit.pauses:
        windowed[first:stop] = 0.0
    return windowed
