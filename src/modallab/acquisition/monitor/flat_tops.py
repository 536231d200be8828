"""Whether the tops of a signal of any shape are cut off at one value.

Near a smooth top a signal is a parabola: half of the samples that lie within four counts of the top lie below the first
of them, and where several in a row read the same, those further out lie no more than a few counts and a few times the
noise below. A top that many samples end at, with none just below it or a steep fall beside it, is flat.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.core.arrays import Real
from modallab.storage.samples import Samples

LONG_RUN = 5
STEEP_STEPS, STEEP_NOISE = 20.0, 40.0
"""Beside a flat top of so many samples the signal falls by so many counts, and so many times the noise, within half of
its length: a parabola falls by 5 counts."""

MOST_AT_TOP, OVER_BELOW = 8, 4
"""A signal is also cut off of which so many samples, and so many times those just below it, lie at the top."""

COARSE = 3
"""So many times as many where the noise is less than a count, and the tops of a sine may well round to one value."""

BELOW_STEPS, BELOW_NOISE = 6.0, 2.0
"""Just below: by so many counts and so many times the noise."""

MOVES = 5.0
"""A channel is judged from so many times the steep fall on: a smaller one ends at few values by itself."""


def flat_tops(window: Samples, noise: RestNoise) -> NDArray[np.bool_]:
    """(channels,) whether the highest, or the lowest, of (channels, n) samples, as delivered, are cut off.

    A channel whose noise does not move what it delivers repeats values by itself, and is not judged.
    """
    rows = window.astype(np.float64)
    moves = np.ptp(rows, axis=1) > MOVES * (STEEP_STEPS * noise.step + STEEP_NOISE * noise.rms)
    found = np.zeros(len(rows), dtype=np.bool_)
    for channel in np.flatnonzero(noise.visible & moves):
        row, rms, step = rows[channel], float(noise.rms[channel]), float(noise.step[channel])
        found[channel] = _is_flat_topped(row, rms, step) or _is_flat_topped(-row, rms, step)
    return found


def _is_flat_topped(row: Real, noise: float, step: float) -> bool:
    top = float(row.max())
    at = np.flatnonzero(row == top)
    if at.size < LONG_RUN:
        return False
    below = int((row >= top - BELOW_STEPS * step - BELOW_NOISE * noise).sum()) - at.size
    most = MOST_AT_TOP if noise >= step else COARSE * MOST_AT_TOP
    if at.size >= most and at.size >= OVER_BELOW * below:
        return True
    begins = at[np.diff(at, prepend=-2) > 1]
    ends = at[np.diff(at, append=at[-1] + 2) > 1]
    run = ends - begins + 1
    out = np.maximum(1, run // 2)
    whole = (run >= LONG_RUN) & (begins >= out) & (ends + out < row.size)
    begins, ends, out = begins[whole], ends[whole], out[whole]
    # The higher of both sides: a jump, as of a dropout, is no top.
    drop = top - np.maximum(row[begins - out], row[ends + out])
    return bool((drop > STEEP_STEPS * step + STEEP_NOISE * noise).any())
