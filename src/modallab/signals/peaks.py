"""Peaks of a curve, each with how far it stands out of what surrounds it."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real


def prominent_peaks(curve: Real, prominence: float) -> NDArray[np.int64]:
    """(peaks,) indices of the local maxima of a curve (n,) that stand out by at least `prominence`, in its unit.

    A peak's prominence is its height above the higher of the two lowest points between it and higher ground on either
    side, or the end of the curve. The middle of a flat top is its peak; an end of the curve is none.

    SciPy's `find_peaks` finds the same; but it comes with all of its statistics, which take longer to load than most
    identifications take.
    """
    return np.array([top for top in _local_maxima(curve) if _prominence(curve, top) >= prominence], np.int64)


def _local_maxima(curve: Real) -> list[int]:
    # Where the curve changes, each run of equal values counts once.
    starts = np.flatnonzero(np.diff(curve, prepend=np.nan) != 0)
    ends = np.append(starts[1:], curve.size) - 1
    level = curve[starts]
    higher = (level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])
    return [int(middle) for middle in (starts[1:-1][higher] + ends[1:-1][higher]) // 2]


def _prominence(curve: Real, top: int) -> float:
    higher = np.flatnonzero(curve > curve[top])
    after = int(np.searchsorted(higher, top))
    first = int(higher[after - 1]) + 1 if after > 0 else 0
    stop = int(higher[after]) if after < higher.size else curve.size
    return float(curve[top] - max(curve[first : top + 1].min(), curve[top:stop].min()))
