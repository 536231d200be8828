"""Lags between channels are properties of the rig, and taken off."""

import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.signals.alignment import align_channels, lags_s

RATE_HZ = 2000.0


def lagging(rig: Rig, **fields: list[float]) -> Rig:
    channels = tuple(
        channel.model_copy(update={name: values[n] for name, values in fields.items()})
        for n, channel in enumerate(rig.channels)
    )
    return rig.model_copy(update={"channels": channels})


def test_a_multiplexers_skew_is_taken_off(rig: Rig):
    # As a 6211 reads: 14 us from channel to channel, 140 us at channel 10, 4.2 degrees at 84 Hz.
    skews = [14e-6 * n for n in range(len(rig.channels))]
    lags = lags_s(lagging(rig, skew_s=skews))
    t = np.arange(2048) / RATE_HZ
    read = np.stack([np.sin(2 * np.pi * 84 * (t + skew)) for skew in skews])
    corrected = align_channels(read, RATE_HZ, lags)
    # All stand at the last channel's times now.
    expected = np.sin(2 * np.pi * 84 * (t + skews[-1]))
    assert np.abs(corrected - expected)[:, 60:-60].max() < 1e-4
    assert np.abs(read[0] - expected).max() > 0.07


def test_a_delay_of_parts_of_a_sample_and_of_many_is_taken_off(rig: Rig):
    lags = np.zeros(len(rig.channels))
    lags[3], lags[5] = 0.3 / RATE_HZ, 7.6 / RATE_HZ
    t = np.arange(2048) / RATE_HZ
    read = np.stack([np.sin(2 * np.pi * 30 * (t - lag)) for lag in lags])
    corrected = align_channels(read, RATE_HZ, lags)
    assert np.abs(corrected - np.sin(2 * np.pi * 30 * t))[:, 60:-60].max() < 1e-4


def test_equal_delays_change_nothing(rig: Rig):
    values = np.random.default_rng(1).standard_normal((len(rig.channels), 300))
    lags = lags_s(lagging(rig, delay_s=[0.019] * len(rig.channels)))
    assert align_channels(values, RATE_HZ, lags) is values


def test_what_cannot_be_taken_off_is_rejected():
    with pytest.raises(DataError, match="modules of one kind"):
        align_channels(np.zeros((2, 300)), RATE_HZ, np.array([0.0, 0.019]))
