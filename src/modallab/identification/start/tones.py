"""The band that sine blocks cover, and what their generator's clock does."""

from collections.abc import Sequence

import numpy as np

from modallab.signals.signals import Signals

BAND_MARGIN = 1.05
CLOCK_PPM = 5.0
"""Two good clocks differ by less than this; it changes no frequency by more than its sigma."""


def default_band(signals: Sequence[Signals]) -> tuple[float, float]:
    """From below the lowest to above the highest drive frequency: a mode there still answers, and still rings."""
    driven = [s.tone.frequency_hz for s in signals]
    return min(driven) / BAND_MARGIN, max(driven) * BAND_MARGIN


def clock_notes(signals: Sequence[Signals]) -> tuple[str, ...]:
    """What is to be said of the generator's clock, by which the measured frequencies are off the recorded ones."""
    offsets = [s.tone.frequency_hz / s.block.frequency_hz - 1 for s in signals if s.block.frequency_hz]
    clock = 1e6 * float(np.median(offsets))
    if not abs(clock) > CLOCK_PPM:
        return ()
    return (
        f"The generator's clock runs {clock:+.0f} ppm against the converter's; the measured frequencies were used.",
    )
