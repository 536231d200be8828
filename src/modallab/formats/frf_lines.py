"""The lines of FRFs that others wrote: swept down they are turned, and coherences are shares of one."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError

Complex = NDArray[np.complex128]

_ROUNDING = 1e-6


def rising(frequency_hz: Real, values: Complex, coherence: Real | None) -> tuple[Real, Complex, Real | None]:
    """Lines (lines,), FRFs and coherences (outputs, inputs, lines) by rising frequency, of a sweep down too."""
    if frequency_hz.size < 2 or not np.all(np.diff(frequency_hz) < 0):
        return frequency_hz, values, coherence
    turned = None if coherence is None else coherence[..., ::-1]
    return frequency_hz[::-1], values[..., ::-1], turned


def share_of_one(coherence: Real, where: str, unit: str = "") -> Real:
    """Coherences, those in % as shares.

    Raises:
        DataError: they are not between 0 and 1.
    """
    share = coherence / 100 if unit == "%" else coherence
    if not ((share >= 0) & (share <= 1 + _ROUNDING)).all():
        raise DataError(
            f"a coherence is not between 0 and 1: they reach {float(np.max(share)):.4g}",
            where=where,
            remedy="write [%] behind the names of columns in percent, or export the coherences again",
        )
    return np.minimum(share, 1.0)
