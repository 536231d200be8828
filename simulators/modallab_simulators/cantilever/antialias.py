"""The anti-alias filter: one linear-phase FIR, applied alike to force and responses."""

import numpy as np
from numpy.typing import NDArray

DELAY = 30
"""Group delay in delivered samples, of the order of a delta-sigma converter's."""

_STOP_DB = 105.0


def lowpass(oversample: int, later: float = 0.0, wait: int = 0) -> NDArray[np.float64]:
    """Taps at `oversample` times the delivered rate, (2 * DELAY * oversample + wait + 1,).

    Kaiser-windowed ideal low-pass at half the delivered rate (Oppenheim and Schafer, Discrete-Time Signal Processing,
    7.5). Flat within 1e-5 up to 0.44 of the delivered rate and 100 dB down from 0.56 of it, so that nothing folds
    back onto what is flat.

    Args:
        oversample: internal samples per delivered one.
        later: how much later than others this row is sampled, in internal samples, up to `wait`.
        wait: what the others wait for it, in internal samples.
    """
    half = DELAY * oversample
    # The first tap weighs the oldest sample.
    n = np.arange(2 * half + wait + 1) - half - later
    inside = np.sqrt(np.maximum(1 - (n / half) ** 2, 0.0))
    taps = np.sinc(n / oversample) * np.where(np.abs(n) <= half, np.i0(0.1102 * (_STOP_DB - 8.7) * inside), 0.0)
    return taps / taps.sum()
