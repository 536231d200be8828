"""Volts as real numbers are no counts: the noise floor is that of the noise, however small its numbers are."""

import numpy as np
import pytest

from modallab.acquisition.monitor.settled import WindowLevels, check_settled, noise_floor_of_windows


@pytest.mark.parametrize("volts_per_count", [1.0, 3e-4])
def test_a_ringing_beam_is_seen_in_volts_as_in_counts(volts_per_count: float):
    rng = np.random.default_rng(2)
    windows = [rng.standard_normal((10, 4096)) * volts_per_count for _ in range(4)]
    ringing = 0.5 * volts_per_count * np.sin(2 * np.pi * 10 * np.arange(4096) / 4096)
    floor = noise_floor_of_windows(windows, counts=volts_per_count == 1.0)
    np.testing.assert_allclose(floor.rms, volts_per_count, rtol=0.05)
    assert check_settled(WindowLevels.of(windows[0], floor.rms), floor).is_settled
    assert not check_settled(WindowLevels.of(windows[1] + ringing, floor.rms), floor).is_settled
