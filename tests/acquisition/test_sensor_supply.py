"""Waiting for the bias of fed sensors: as long as it fades, however slowly, and no longer for noise or ringing."""

import numpy as np
import pytest

from modallab.acquisition.procedures.sensors import wait_until_settled

RATE_HZ = 1000.0


def reader(signal):
    place = 0

    def pull(count: int):
        nonlocal place
        times = (place + np.arange(count)) / RATE_HZ
        place += count
        return np.stack([signal(times), 1e-3 * RNG.standard_normal(count)])

    return pull


RNG = np.random.default_rng(7)


def noise(times):
    return 3e-4 * RNG.standard_normal(len(times))


def test_what_has_settled_already_costs_two_windows():
    assert wait_until_settled(reader(noise), {0: "force", 1: "a1"}, RATE_HZ).seconds == 1.0


@pytest.mark.parametrize(("decay_s", "at_least_s"), [(0.455, 3.5), (5.0, 30.0)])
def test_a_bias_is_waited_for_until_the_noise_hides_it(decay_s: float, at_least_s: float):
    wait = wait_until_settled(reader(lambda t: 4.9 * np.exp(-t / decay_s) + noise(t)), {0: "force"}, RATE_HZ)
    assert not wait.unsettled
    assert at_least_s <= wait.seconds <= 2.5 * at_least_s
    # What is left at the end is no more than the noise.
    assert 4.9 * np.exp(-wait.seconds / decay_s) < 6e-4


def test_a_ringing_beam_is_no_bias():
    ringing = wait_until_settled(reader(lambda t: 0.1 * np.sin(2 * np.pi * 4.755 * t) + noise(t)), {0: "a1"}, RATE_HZ)
    assert ringing.seconds <= 2.0


def test_what_never_settles_is_named_after_the_patience():
    wait = wait_until_settled(reader(lambda t: 0.01 * t + noise(t)), {0: "force", 1: "a1"}, RATE_HZ, 10.0)
    assert wait.unsettled == ("force",)
    assert wait.seconds == 10.0


def test_nothing_is_read_where_nothing_is_fed():
    def pull(_count: int):
        raise AssertionError

    assert wait_until_settled(pull, {}, RATE_HZ).seconds == 0.0
