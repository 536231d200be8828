"""Resampling keeps what is below 0.4 of the rate, for every rate a device may give."""

import numpy as np
import pytest

from modallab.bench.resampling import PASS, resample, samples_on_either_side

NI_GRID_HZ = 13.1072e6 / 256
CASES = [
    (2048.0, 2000.0, 2048),
    (2048.0, 1000.0, 1024),
    (NI_GRID_HZ / 31, 1000.0, 1024),
    (51_200.0, 2000.0, 512),
    (NI_GRID_HZ / 12, 4000.0, 2048),
]


@pytest.mark.parametrize(("from_hz", "to_hz", "count"), CASES)
def test_a_sine_up_to_two_fifths_of_the_rate_is_kept_to_a_millionth(from_hz: float, to_hz: float, count: int):
    half = samples_on_either_side(from_hz, to_hz)
    n = half + int(np.ceil(count * from_hz / to_hz)) + half + 1
    t_old, t_new = (np.arange(n) - half) / from_hz, np.arange(count) / to_hz
    tones = np.linspace(0.01, PASS, 40) * to_hz
    old = np.sin(2 * np.pi * tones[:, None] * t_old + 0.3)
    new = resample(old, from_hz, to_hz, half, count)
    assert np.abs(new - np.sin(2 * np.pi * tones[:, None] * t_new + 0.3)).max() < 1e-6


@pytest.mark.parametrize(("from_hz", "to_hz", "count"), CASES[1:4])
def test_what_would_fold_back_is_gone(from_hz: float, to_hz: float, count: int):
    half = samples_on_either_side(from_hz, to_hz)
    n = 2 * half + int(np.ceil(count * from_hz / to_hz)) + 1
    tones = np.linspace(1 - PASS, 0.49 * from_hz / to_hz, 10) * to_hz
    old = np.sin(2 * np.pi * tones[:, None] * np.arange(n) / from_hz)
    assert np.abs(resample(old, from_hz, to_hz, half, count)).max() < 1e-6


def test_a_constant_stays_what_it_is_and_counts_are_taken_as_numbers():
    half = samples_on_either_side(2048.0, 2000.0)
    old = np.full((2, 300), [[7], [-3]], dtype=np.int16)
    new = resample(old, 2048.0, 2000.0, half, 100)
    np.testing.assert_allclose(new, [[7.0] * 100, [-3.0] * 100], rtol=1e-14)


def test_a_block_that_was_not_padded_is_rejected():
    with pytest.raises(ValueError, match="too few"):
        resample(np.zeros((1, 2100)), 2048.0, 2000.0, 0, 2048)
