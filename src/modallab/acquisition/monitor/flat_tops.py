"""Whether the tops of a signal of any shape are cut off at one value.

Near a smooth top a signal is a parabola: where k samples in a row read the same, those further out lie no more than a
few counts and a few times the noise below them. Where they lie far below, the top is flat. A single pair may be so by
chance; several that end at the same value are not.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.storage.samples import Samples

Real = NDArray[np.float64]

LONG_RUN, MIDDLE_RUN = 5, 3
STEEP_STEPS, STEEP_NOISE = 20.0, 40.0
"""Below the flat top by so many counts, and so many times the noise: a parabola lies at most 5 counts below it."""

PAIR_STEPS, PAIR_NOISE = 100.0, 200.0
"""For pairs, which a sine that is sampled symmetrically about its top shows as well."""

MIDDLES, TOPS = 2, 3
"""So many flat tops of at least 3 samples, or of at least 2, all of one value, are a channel that is cut off."""


def flat_tops(window: Samples, noise: Real, step: Real) -> NDArray[np.bool_]:
    """(channels,) whether the highest, or the lowest, samples of a (channels, n) window are cut off.

    Args:
        window: as delivered.
        noise: (channels,) rms from sample to sample.
        step: (channels,) the converter's count.
    """
    return np.array(
        [
            _one(row, float(row.max()), n, s) or _one(-row, float(-row.min()), n, s)
            for row, n, s in zip(window.astype(np.float64), noise, step, strict=True)
        ]
    )


def _one(row: Real, top: float, noise: float, step: float) -> bool:
    at = np.flatnonzero(row == top)
    if at.size < LONG_RUN and at.size < 2 * MIDDLES:
        return False
    begins = at[np.diff(at, prepend=-2) > 1]
    ends = at[np.diff(at, append=at[-1] + 2) > 1]
    run = ends - begins + 1
    out = np.maximum(1, run // 2)
    whole = (begins >= out) & (ends + out < row.size) & (run > 1)
    begins, ends, run, out = begins[whole], ends[whole], run[whole], out[whole]
    # Each side by itself: a jump, as of a dropout, is no top.
    drop = top - np.maximum(row[begins - out], row[ends + out])
    steep = drop > STEEP_STEPS * step + STEEP_NOISE * noise
    pairs = drop > PAIR_STEPS * step + PAIR_NOISE * noise
    middles = steep & (run >= MIDDLE_RUN)
    return bool(
        (steep & (run >= LONG_RUN)).any() or middles.sum() >= MIDDLES or (middles | (pairs & (run > 1))).sum() >= TOPS
    )
