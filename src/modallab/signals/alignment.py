"""Channels of a rig that lag or lead one another, brought onto the times of the one that lags least.

A converter's filter makes samples late by `delay_s`; a multiplexer reads a channel `skew_s` after channel 0, so that
its samples are ahead. Only the difference between channels matters to an FRF, and only it is taken off.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.signals.checks import check_channels

HALF = 24
"""Samples to either side of a new one."""

_BETA = 10.0


def lags_s(rig: Rig) -> NDArray[np.float64]:
    """(channels,) by how much each channel's samples lag those of the one that lags least."""
    lags = np.array([channel.delay_s - channel.skew_s for channel in rig.channels])
    return lags - lags.min()


def align_channels(values: NDArray[np.float64], rate_hz: float, lags: NDArray[np.float64]) -> NDArray[np.float64]:
    """(channels, n) with each channel's lag taken off; where it must look past an end, the end is turned over there.

    Args:
        values: (channels, n), n above 48 where there is a lag.
        rate_hz: sampling rate.
        lags: (channels,) s, none below zero; see `lags_s`.

    Raises:
        DataError: values that are no records, lags that are none or not one a channel, or a lag so long, or a block so
            short, that the block's end would be made up.
    """
    check_rate(rate_hz)
    check_channels(values, lags.size)
    if lags.ndim != 1 or not (np.isfinite(lags).all() and np.all(lags >= 0)):
        found = f"the lags of the channels are {lags.tolist()} s"
        raise DataError(found, remedy="give finite times, counted from the channel that lags least")
    if not lags.any():
        return values
    if lags.max() * rate_hz > HALF:
        raise DataError(
            f"a channel lags by {1e3 * lags.max():.3g} ms, {lags.max() * rate_hz:.0f} samples",
            where="rig file field channels[].delay_s",
            remedy="connect all channels to modules of one kind",
        )
    if values.shape[1] <= 2 * HALF:
        found = f"{values.shape[1]} samples are too few to shift a channel by a part of a sample"
        raise DataError(found, remedy=f"record blocks of more than {2 * HALF} samples")
    return np.stack([_delay_row(row, lag * rate_hz) if lag else row for row, lag in zip(values, lags, strict=True)])


def _delay_row(row: NDArray[np.float64], samples: float) -> NDArray[np.float64]:
    pad = 2 * HALF
    padded = np.concatenate([2 * row[0] - row[pad:0:-1], row, 2 * row[-1] - row[-2 : -pad - 2 : -1]])
    whole = int(np.floor(samples))
    offset = np.arange(-HALF, HALF + 1) - (samples - whole)
    window: NDArray[np.float64] = np.i0(_BETA * np.sqrt(np.maximum(0, 1 - (offset / (HALF + 1)) ** 2)))
    taps: NDArray[np.float64] = np.sinc(offset) * window
    taps /= taps.sum()
    first = pad + whole - HALF
    corrected: NDArray[np.float64] = np.convolve(padded[first : first + row.size + 2 * HALF], taps[::-1], mode="valid")
    return corrected
