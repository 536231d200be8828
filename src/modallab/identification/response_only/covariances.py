"""Output covariances of long records, as a whole and in segments, at a rate that suits a band."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import DataError

DECIMATION = 4
"""From one band to the next lower one."""
OWNED = (0.1, 0.4)
"""Shares of a band's rate between which its modes stand: their periods are sampled finely, and the filter is flat."""
LAST = 2.0
"""A band reaches down to the lower edge if its own is no more than so many times as high."""
STOP_DB = 80.0
FILTER_LAGS = 10
"""Samples of a decimated band beyond which the filter's own correlation is nothing."""
SEGMENTS = 24
"""Pieces of the records whose covariances scatter: few leave the sigmas rough, short ones depend on one another."""


@dataclass(frozen=True, eq=False, slots=True)
class BandCovariances:
    """Responses at the rate of one band.

    Attributes:
        records: each (outputs, samples).
        rate_hz: their rate.
        low_hz: modes below are another band's.
        high_hz: modes above are another band's.
        first_lag: covariances from this lag on are those of free decays alone.
    """

    records: tuple[Real, ...]
    rate_hz: float
    low_hz: float
    high_hz: float
    first_lag: int


def covariances_by_band(
    records: Sequence[Real], rate_hz: float, band_hz: tuple[float, float]
) -> Iterator[BandCovariances]:
    """The records at their own rate, then each a quarter of it, down to the lower edge.

    Args:
        records: each (outputs, samples), without means.
        rate_hz: their rate.
        band_hz: in which modes are looked for.
    """
    first_lag, top = 1, OWNED[1] * rate_hz
    while True:
        low = OWNED[0] * rate_hz
        last = low <= LAST * band_hz[0]
        low = band_hz[0] if last else low
        if low < band_hz[1]:
            yield BandCovariances(tuple(records), rate_hz, max(low, band_hz[0]), min(top, band_hz[1]), first_lag)
        if last:
            return
        records, rate_hz = [_decimate_record(r) for r in records], rate_hz / DECIMATION
        first_lag, top = FILTER_LAGS, low


def _decimate_record(record: Real) -> Real:
    """By a filter without phase, flat up to 0.4 of the new rate and deaf from 0.6 on."""
    # Imported here: who knows the forces needs none of it.
    from scipy import signal

    taps, beta = signal.kaiserord(STOP_DB, 2 * (OWNED[1] / 2) / DECIMATION)
    # Coefficients are taken as well as a window's name, which the stubs do not know.
    window: Any = signal.firwin(int(taps) | 1, 1 / DECIMATION, window=("kaiser", beta))
    return np.asarray(signal.resample_poly(record, 1, DECIMATION, axis=1, window=window), np.float64)


class TooShortError(DataError):
    """Records too short for the lowest modes that are asked for."""


def segment_covariances(band: BandCovariances, lags: int) -> Real:
    """Covariances (segments, lags, outputs, outputs) E[y(t + k) y(t)^T], k from the band's first lag on.

    Their mean is that of all records. A segment's products may reach into the next one's samples.

    Args:
        band: whose records are divided into segments of one length.
        lags: how many.

    Raises:
        DataError: the records are too short.
    """
    reach = band.first_lag + lags
    usable = [r.shape[1] - reach for r in band.records]
    length = _segment_length(usable)
    if length < reach:
        raise TooShortError(
            f"{sum(r.shape[1] for r in band.records) / band.rate_hz:.3g} s of records are too short for modes from "
            f"{band.low_hz:.3g} Hz on",
            remedy="record longer, or raise the lower edge of the band",
        )
    found: list[Real] = []
    for record, n in zip(band.records, usable, strict=True):
        count = n // length
        if count:
            found.append(_lagged_products(record, count, length, band.first_lag, lags))
    return np.concatenate(found)


def _segment_length(usable: Sequence[int]) -> int:
    """The longest segment of which the records hold enough."""
    length = max(1, sum(max(0, n) for n in usable) // SEGMENTS)
    while length > 1 and sum(max(0, n) // length for n in usable) < SEGMENTS:
        length -= max(1, length // 50)
    return length


def _lagged_products(record: Real, count: int, length: int, first: int, lags: int) -> Real:
    outputs = len(record)

    def pieces(k: int) -> Real:
        return record[:, k : k + count * length].reshape(outputs, count, length).transpose(1, 0, 2)

    now = pieces(0).transpose(0, 2, 1)
    return np.stack([pieces(first + k) @ now / length for k in range(lags)], axis=1)
