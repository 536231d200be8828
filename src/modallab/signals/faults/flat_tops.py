"""Flat tops: a channel that ran into the end of a range that nobody has stated.

The top of a smooth signal is a parabola: over L samples that differ by a step at most, the next one lies no more than
(1 + 2 / L)^2 steps below. A signal that is cut off arrives at its top with the slope it had. Where tops last a sample
or two only, their number tells: within a step of the largest top there are no more samples than in the three steps
below, even if all tops are as high.
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.repeats import SampleFault, SampleRuns, stretches_where

LEAST_RUN = 3
"""Equal samples in a row: two may stand astride any top."""
SHARP = 3.0
"""How many times further than a parabola's the next sample lies below, or how many times as many stand at the top."""
NOISY_LEAST, NOISY_SHARP = 5, 6.0
"""Samples in all, and the same, of tops that are flat within the noise behind the stage that cut them off. Two modes
can make a top without curvature: it leaves a band of three samples by 16 times its width, which is less."""
NOISY_TOPS = 0.005
"""Largest share of its height within which such a top is flat."""
WITHIN = 4.0
"""Deviations of a known noise that a flat top of a few samples spans."""
WIDTHS = 2.0**10
"""Range of the bands that are tried, each twice as wide as the last."""
LEAST_HEIGHT = 0.1
"""Share of the largest excursion from the median: a level of rest is no top."""


def flat_tops(
    row: Real, rate_hz: float, channel: str, steps: Real, noise: float | None = None
) -> tuple[SampleFault, ...]:
    """The flat tops of a channel (n,), upper and lower ones by themselves.

    Args:
        row: the samples.
        rate_hz: their rate.
        channel: its name.
        steps: (n,) as of `steps_of`.
        noise: standard deviation, where it is known as that of a force outside of its hit; None if not.
    """
    ends, middle = (int(row.argmax()), int(row.argmin())), float(np.median(row))
    largest = max(abs(float(row[end]) - middle) for end in ends)
    found: list[SampleFault] = []
    for sign, end in zip((1.0, -1.0), ends, strict=True):
        top = float(row[end])
        height = abs(top - middle)
        if height < LEAST_HEIGHT * largest or height == 0:
            continue
        runs = _cut_off(sign * row, sign * top, float(steps[end]), height)
        if noise is not None and not runs.first.size:
            runs = _within(sign * row, sign * top, float(steps[end]) + WITHIN * noise)
        if runs.first.size:
            what = f"flat {'tops' if sign > 0 else 'bottoms'} at {top:.6g}"
            found.append(SampleFault(channel, what, float(runs.first[0]) / rate_hz, int(runs.length.sum())))
    return tuple(found)


def _cut_off(row: Real, top: float, step: float, height: float) -> SampleRuns:
    found = _is_sharp(row, top, step, stretches_where(row == top).at_least(LEAST_RUN), SHARP)
    if found.first.size:
        return found
    if _is_crowded(row, top, step):
        return stretches_where(row >= top - step / 2)
    # How much noise there is behind the stage is not known: a flat top is flat in one of these bands.
    widest = NOISY_TOPS * height + step
    band = max(step, widest / WIDTHS)
    while found.length.sum() < NOISY_LEAST and band <= widest:
        found = _within(row, top, band)
        band *= 2
    return found if found.length.sum() >= NOISY_LEAST else SampleRuns(found.first[:0], found.stop[:0])


def _within(row: Real, top: float, band: float) -> SampleRuns:
    """The tops that are flat within a band of noise."""
    return _is_sharp(row, top, band, stretches_where(row >= top - band).at_least(LEAST_RUN), NOISY_SHARP)


def _is_crowded(row: Real, top: float, step: float) -> bool:
    """Whether more samples stand at the top than at tops that are as high; what repeats with its neighbours is one."""
    at = np.flatnonzero(row[1:-1] >= top - step / 2) + 1
    beside = np.unique(np.stack([row[at - 1], row[at + 1]]), axis=1).shape[1]
    below = np.count_nonzero((row < top - step / 2) & (row > top - 3.5 * step))
    return beside >= NOISY_LEAST and beside > SHARP * (below + 1)


def _is_sharp(row: Real, top: float, step: float, runs: SampleRuns, times: float) -> SampleRuns:
    inside = runs.away_from_ends(row.size)
    below = top - np.maximum(row[inside.first - 1], row[inside.stop % row.size])
    limit = times * step * (1 + 2 / inside.length) ** 2
    return SampleRuns(inside.first[below > limit], inside.stop[below > limit])
