"""Flat tops: a channel that ran into the end of a range that nobody has stated.

The top of a smooth signal is a parabola: over L samples that differ by a step at most, the next one lies no more than
(1 + 2 / L)^2 steps below. A signal that is cut off arrives at its top with the slope it had.
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.signals.faults.runs import Fault, SampleRuns, runs_where

LEAST_RUN = 3
"""Equal samples in a row: two may stand astride any top."""
SHARP = 3.0
"""How many times further than a parabola's the next sample lies below."""
NOISY_RUN, NOISY_SHARP = 5, 6.0
"""The same of tops that are flat within the noise behind the stage that cut them off."""
NOISY_TOPS = 0.005
"""Share of its height within which such a top is flat."""
LEAST_HEIGHT = 0.1
"""Share of the largest excursion from the median: a level of rest is no top."""


def flat_tops(row: Real, rate_hz: float, channel: str, steps: Real) -> tuple[Fault, ...]:
    """The flat tops of a channel (n,), upper and lower ones by themselves; `steps` (n,) as of `steps_of`."""
    ends, middle = (int(row.argmax()), int(row.argmin())), float(np.median(row))
    largest = max(abs(float(row[end]) - middle) for end in ends)
    found: list[Fault] = []
    for sign, end in zip((1.0, -1.0), ends, strict=True):
        top = float(row[end])
        height = abs(top - middle)
        if height < LEAST_HEIGHT * largest or height == 0:
            continue
        runs = _cut_off(sign * row, sign * top, float(steps[end]), height)
        if runs.first.size:
            what = f"flat {'tops' if sign > 0 else 'bottoms'} at {top:.6g}"
            found.append(Fault(channel, what, float(runs.first[0]) / rate_hz, int(runs.length.sum())))
    return tuple(found)


def _cut_off(row: Real, top: float, step: float, height: float) -> SampleRuns:
    exact = _is_sharp(row, top, step, runs_where(row == top).longer(LEAST_RUN), SHARP)
    if exact.first.size:
        return exact
    # What is flat within a step of the converter is flat by that step.
    band = NOISY_TOPS * height + step
    return _is_sharp(row, top, band, runs_where(row >= top - band).longer(NOISY_RUN), NOISY_SHARP)


def _is_sharp(row: Real, top: float, step: float, runs: SampleRuns, times: float) -> SampleRuns:
    inside = runs.within(row.size)
    below = top - np.maximum(row[inside.first - 1], row[inside.stop % row.size])
    limit = times * step * (1 + 2 / inside.length) ** 2
    return SampleRuns(inside.first[below > limit], inside.stop[below > limit])
