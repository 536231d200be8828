"""What the output of the bench can play."""

from math import isfinite

import numpy as np

from modallab.bench.protocol import Burst, Waveform
from modallab.core.errors import ConfigurationError

OUTPUT_RANGE_V = 10.0


def require_burst(burst: Burst, rate_hz: float) -> None:
    """Reject a sine that the output cannot play.

    Raises:
        ConfigurationError: its frequency, amplitude or times are out of range.
    """
    problems = {
        "frequency_hz": 0 < burst.frequency_hz < rate_hz / 2,
        "amplitude_v": 0 < burst.amplitude_v <= OUTPUT_RANGE_V,
        "ramp_s": isfinite(burst.ramp_s) and burst.ramp_s >= 0,
        "hold_s": isfinite(burst.hold_s) and burst.hold_s >= 0,
    }
    wrong = [f"{name} = {getattr(burst, name)}" for name, good in problems.items() if not good]
    if wrong or burst.duration_s == 0:
        raise ConfigurationError(
            f"a burst of {', '.join(wrong) or 'no duration'}",
            remedy=f"frequency above 0 to half the rate, amplitude above 0 to {OUTPUT_RANGE_V:g} V, times from 0",
        )


def require_wave(wave: Waveform, where: str) -> None:
    """Reject a wave that the output cannot play.

    Raises:
        ConfigurationError: it does not begin and end at 0 V, or is beyond the range.
    """
    if not np.abs(wave.samples).max() <= OUTPUT_RANGE_V or wave.samples[0] != 0 or wave.samples[-1] != 0:
        raise ConfigurationError(
            f"a wave up to {np.abs(wave.samples).max():g} V, from {wave.samples[0]:g} to {wave.samples[-1]:g} V",
            where=where,
            remedy=f"let it begin and end at 0 V and stay within {OUTPUT_RANGE_V:g} V",
        )
