"""The noise of each row of the converter, from the records themselves.

Spectra under a Hann window (Welch, IEEE Trans. Audio Electroacoust. 15, 1967, 70), whose lines hold exponentially
distributed powers for Gaussian noise (Bendat and Piersol, Random Data, 2010); a converter's rounding has the variance
step^2 / 12 (Bennett, Bell Syst. Tech. J. 27, 1948, 446).
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.frf.broadband import driven_band
from modallab.signals.signals import to_signals

NOISE_BAND = (0.62, 0.94)
"""Share of the Nyquist frequency in which a bench answers little."""
LEAST_V = 1e-12
"""Where neither the rig file nor the numbers say what the noise is, the records must."""
PRE_TRIGGER = 64
"""Samples before a hit that are used, fewer if there are fewer."""

FAR_HZ, LOW_HZ = 60.0, 9.0
"""A drive above the first leaves nothing below the second under a Hann window."""
LEAST_BLOCKS = 4
"""Blocks from which the rise of the noise to low frequencies can be estimated."""
RISES_HZ = 0.5
"""Corner, at the median row's noise, from which noise counts as rising: beyond chance in a few blocks of all rows."""


def noise_of_rig_file(rig: Rig, blocks: Sequence[Block]) -> Real:
    """(rows,) V rms the rig file promises: the converter's noise, and its rounding."""
    counted = [b.scale for b in blocks if b.samples.dtype.kind in "iu"]
    known = rig.converter.volts_per_count if rig.converter is not None else 0.0
    steps = np.max(np.abs(counted), axis=0) if counted else np.full(len(rig.channels), known)
    own = rig.converter.noise_rms_v if rig.converter is not None else steps
    return np.maximum(np.hypot(own, steps / np.sqrt(12)), LEAST_V)


def measured_noise(blocks: Sequence[Block], rig: Rig) -> Real:
    """(rows,) V rms above 0.6 of the Nyquist frequency, scaled to the whole band; NaN where no record tells.

    The lower quartile over the records: what is in every record is noise, what is in some is a response.
    """
    force = rig.force_channel.index
    spreads = [spread for b in blocks if (spread := _noise_of_block(b, force, _driven_to(b, rig))) is not None]
    if not spreads:
        return np.full(len(blocks[0].scale) if blocks else 0, np.nan)
    return np.quantile(np.array(spreads), 0.25, axis=0)


def lines_of_noise_estimate(blocks: Sequence[Block]) -> int:
    """Lines of spectra that the measured noise rests on."""
    share = (NOISE_BAND[1] - NOISE_BAND[0]) / 2
    return sum(int(share * (PRE_TRIGGER if b.test == "impact" else b.n_samples)) for b in blocks)


def _driven_to(block: Block, rig: Rig) -> float:
    """Share of the Nyquist frequency up to which a broadband drive reaches."""
    return driven_band([to_signals(block, rig)])[1] * 2 / block.rate_hz if block.test in BROADBAND else 0.0


def _noise_of_block(block: Block, force: int, driven_to: float = 0.0) -> Real | None:
    volts = block.samples * block.scale[:, None]
    if block.test == "impact":
        before = min(PRE_TRIGGER, int(np.argmax(np.abs(volts[force]))) - 30)
        if before < 24:
            return None
        volts = volts[:, :before]
    n = volts.shape[1]
    window = np.hanning(n)
    spectrum = np.fft.rfft((volts - volts.mean(axis=1, keepdims=True)) * window, axis=1)
    low, high = (int(max(share, driven_to) * n / 2) for share in NOISE_BAND)
    if low >= high:
        return None
    power = np.abs(spectrum[:, low:high]) ** 2
    # The median of an exponential variable is its mean times ln 2; a line of a harmonic cannot move it.
    return np.sqrt(np.median(power, axis=1) / np.log(2) / np.sum(window**2))


def noise_for_weights(measured: Real, believed: Real) -> Real:
    """(rows,) V rms to weigh with: what was measured where it is beyond doubt larger than believed."""
    return np.where(np.nan_to_num(measured) > 1.25 * believed, np.nan_to_num(measured), believed)


def measured_row_noise(blocks: Sequence[Block], believed: Real, force: int) -> Real:
    """(rows,) V rms of each row as the sine blocks show it, above all drives; as believed where they are few.

    Half of all blocks lie below their median: other than a quartile it is not low by chance.
    """
    spreads = [s for b in blocks if b.test == "sine" and (s := _noise_of_block(b, force)) is not None]
    if len(spreads) < LEAST_BLOCKS:
        return believed
    return np.maximum(np.median(np.array(spreads), axis=0), LEAST_V)


def low_frequency_noise_power(blocks: Sequence[Block], noise_v: Real, still: Sequence[int] = ()) -> float:
    """Power at 1 Hz, in V^2 per sample, of noise that rises to low frequencies as 1 / f; 0 if none does.

    From what sine blocks far above leave there, where nothing of the drive is: all rows share their converter, so that
    this part of the noise is alike in volts on all of them, whatever their own white noise.

    Args:
        blocks: the records.
        noise_v: (rows,) V rms of each row.
        still: the rows to go by where others move by themselves; all if empty.
    """
    far = [b for b in blocks if b.test == "sine" and (b.frequency_hz or 0.0) > FAR_HZ]
    if len(far) < LEAST_BLOCKS:
        return 0.0
    powers: list[Real] = []
    for b in far:
        volts = b.samples * b.scale[:, None]
        window = np.hanning(b.n_samples)
        spectrum = np.fft.rfft((volts - volts.mean(axis=1, keepdims=True)) * window, axis=1)
        powers.append(np.abs(spectrum) ** 2 / np.sum(window**2))
    power = np.median(np.array(powers), axis=0) / np.log(2)
    hz = np.arange(power.shape[1]) * far[0].rate_hz / far[0].n_samples
    low = (np.arange(power.shape[1]) > 1) & (hz < LOW_HZ)
    if not np.any(low):
        return 0.0
    rows = list(still) or range(len(noise_v))
    found = float(np.median([np.mean(hz[low] * (power[row, low] - noise_v[row] ** 2)) for row in rows]))
    return found if found > RISES_HZ * float(np.median(noise_v)) ** 2 else 0.0
