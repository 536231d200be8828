"""Several devices that sample as one: how they are bound, and what the self-test sees if they are not."""

import numpy as np
import pytest

from modallab.commissioning.synchronisation_check import delay_between

RATE_HZ = 51_200.0
RNG = np.random.default_rng(3)
TIMES = np.arange(2 * 51_200) / RATE_HZ


def sine(times):
    return np.sin(2 * np.pi * 1000.0 * times)


def speech(times):
    """Broad-band, the same at any time that is asked for."""
    frequencies = np.random.default_rng(5).uniform(100.0, 9000.0, 200)
    return sum(np.sin(2 * np.pi * f * times + f) for f in frequencies) / 10


@pytest.mark.parametrize("signal", [sine, speech])
@pytest.mark.parametrize("delay_s", [0.0, 28e-9, 5e-6, 7.3 / RATE_HZ])
def test_the_delay_between_two_channels_is_found_within_its_sigma(signal, delay_s: float):
    noise = 1e-4 * RNG.standard_normal((2, len(TIMES)))
    found = delay_between(signal(TIMES) + noise[0], signal(TIMES - delay_s) + noise[1], RATE_HZ)
    assert found is not None
    assert abs(found.seconds - delay_s) < 5 * found.sigma_s + 1e-3 * delay_s
    # A tenth of a degree at 10 kHz can be told from none.
    assert found.degrees(found.sigma_s) < 0.02


def test_two_channels_without_a_common_signal_have_no_phase():
    assert delay_between(*RNG.standard_normal((2, len(TIMES))), RATE_HZ) is None
