"""The anti-alias filter: one linear-phase FIR, applied alike to force and responses."""

import numpy as np
from numpy.typing import NDArray

DELAY = 30
"""Group delay in delivered samples, of the order of a delta-sigma converter's."""

_STOP_DB = 105.0


def lowpass(oversample: int) -> NDArray[np.float64]:
    """Taps at `oversample` times the delivered rate, symmetric, (2 * DELAY * oversample + 1,).

    Kaiser-windowed ideal low-pass at half the delivered rate (Oppenheim and Schafer, Discrete-Time Signal Processing,
    7.5). Flat within 1e-5 up to 0.44 of the delivered rate and 100 dB down from 0.56 of it, so that nothing folds
    back onto what is flat.
    """
    half = DELAY * oversample
    n = np.arange(-half, half + 1)
    taps = np.sinc(n / oversample) * np.kaiser(2 * half + 1, 0.1102 * (_STOP_DB - 8.7))
    return taps / taps.sum()
