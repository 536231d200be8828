"""The sine in each block's force, at its own frequency, and the band that such blocks cover."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.block import Signals
from modallab.core.errors import DataError
from modallab.signals.tone_fit import SineFit, fit_frequency, strongest_near

BAND_MARGIN = 1.05
CLOCK_PPM = 5.0
"""Two good clocks differ by less than this; it changes no frequency by more than its sigma."""


@dataclass(frozen=True, eq=False, slots=True)
class Tone:
    """A sine block and the sine in its force."""

    signals: Signals
    fit: SineFit


def fit_tone(signals: Signals) -> Tone:
    """The sine in a block's force, at its own frequency, which the generator's clock decides."""
    requested = signals.block.frequency_hz
    if requested is None:
        raise DataError(
            "no frequency is recorded", where=f"record {signals.block.name}", remedy="give the record's frequency_hz"
        )
    start = strongest_near(signals.force, signals.rate_hz, requested)
    fit = fit_frequency(signals.force[None], signals.rate_hz, start)
    if np.abs(fit.amplitude[0]) < 5 * fit.residual_rms[0] * np.sqrt(2 / signals.force.size):
        raise DataError(
            f"no sine at {requested:.4g} Hz in the force: {np.abs(fit.amplitude[0]):.3g} N",
            where=f"record {signals.block.name}",
            remedy="check that the shaker was on, or leave the record out",
        )
    return Tone(signals, fit)


def default_band(tones: Sequence[Tone]) -> tuple[float, float]:
    """From below the lowest to above the highest drive frequency: a mode there still answers, and still rings."""
    driven = [t.fit.frequency_hz for t in tones]
    return min(driven) / BAND_MARGIN, max(driven) * BAND_MARGIN


def clock_notes(tones: Sequence[Tone]) -> tuple[str, ...]:
    """What is to be said of the generator's clock, by which the measured frequencies are off the recorded ones."""
    offsets = [t.fit.frequency_hz / t.signals.block.frequency_hz - 1 for t in tones if t.signals.block.frequency_hz]
    clock = 1e6 * float(np.median(offsets))
    if not abs(clock) > CLOCK_PPM:
        return ()
    return (
        f"The generator's clock runs {clock:+.0f} ppm against the converter's; the measured frequencies were used.",
    )
