"""A slow mode far below the noise is still seen; noise and hum alone are rest."""

import numpy as np
import pytest
from scipy.stats import chi2

from modallab.acquisition.monitor.settled import (
    FLOOR_SCATTER,
    NoiseFloor,
    SettledCheck,
    WindowLevels,
    amplitude_of_motion,
    check_settled,
    largest_ratio,
    lines_above_noise,
    mean_sensor_motion,
    motion_decays,
    noise_floor_of_windows,
    noise_limit,
    sensor_motion,
)

RATE, N, CHANNELS = 2000.0, 4096, 10
T = np.arange(N) / RATE
SHAPE = 1 - np.cos(np.pi * np.arange(1, CHANNELS + 1) / (2 * CHANNELS))
SIGMA = np.sqrt(0.983**2 + 1 / 12)


def window(rng: np.random.Generator, tone: np.ndarray | float = 0.0) -> np.ndarray:
    """Counts of a 16-bit converter: 0.3 mV of noise at 0.305 mV a count."""
    return np.rint(rng.normal(0, 0.983, (CHANNELS, N)) + tone)


def ringing(rng: np.random.Generator, tip: float, hz: float = 4.8) -> np.ndarray:
    """The first mode with `tip` noise rms at the free end."""
    return tip * SIGMA * SHAPE[:, None] * np.sin(2 * np.pi * hz * T + rng.uniform(0, 2 * np.pi))


def check(samples: np.ndarray, floor: NoiseFloor) -> SettledCheck:
    return check_settled(WindowLevels.of(samples, floor.rms), floor)


def residual_ratio(before: np.ndarray, block: np.ndarray, floor: NoiseFloor) -> tuple[float, int]:
    moves, lines = lines_above_noise(WindowLevels.of(before, floor.rms), floor)
    return largest_ratio(moves, lines, mean_sensor_motion(sensor_motion(block, before.shape[1], floor)))


@pytest.fixture(scope="module")
def floor() -> NoiseFloor:
    rng = np.random.default_rng(0)
    return noise_floor_of_windows([window(rng) for _ in range(4)])


def test_noise_alone_is_rest(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(1)
    assert all(check(window(rng), floor).is_settled for _ in range(200))


def test_a_fifth_of_the_noise_at_the_free_end_is_no_rest_though_its_level_is(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(2)
    looks = [check(window(rng, ringing(rng, 0.2, 4.8 + rng.uniform(-0.25, 0.25))), floor) for _ in range(200)]
    assert not any(look.is_settled for look in looks)
    assert max(look.level for look in looks) < 1.1
    assert all(abs(look.line * RATE / N - 4.8) < 0.8 for look in looks)


def test_a_twentieth_of_the_noise_passes(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(3)
    assert np.mean([check(window(rng, ringing(rng, 0.05)), floor).is_settled for _ in range(100)]) > 0.97


def test_a_loud_channel_is_no_rest(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(4)
    loud = window(rng)
    loud[3] *= 2
    look = check(loud, floor)
    assert look.level == pytest.approx(2, rel=0.1)
    assert not look.is_settled


def test_a_hum_that_was_there_from_the_start_is_part_of_the_floor() -> None:
    rng = np.random.default_rng(5)
    hum = 5 * np.sin(2 * np.pi * 50 * T)
    humming = noise_floor_of_windows([window(rng, hum) for _ in range(4)])
    assert all(check(window(rng, hum), humming).is_settled for _ in range(50))
    assert not check(window(rng, hum + ringing(rng, 0.3)), humming).is_settled


@pytest.mark.parametrize("offset", [1e3, 1e9])
def test_an_offset_is_no_motion_and_hides_none(floor: NoiseFloor, offset: float) -> None:
    rng = np.random.default_rng(6)
    assert check(window(rng) + offset, floor).is_settled
    assert not check(window(rng, ringing(rng, 0.3)) + offset, floor).is_settled


def test_a_channel_below_one_count_has_the_rounding_as_its_floor() -> None:
    still = noise_floor_of_windows([np.zeros((2, 512))] * 4)
    np.testing.assert_allclose(still.rms, 1 / np.sqrt(12))
    assert check(np.zeros((2, 512)), still).is_settled


@pytest.mark.parametrize("channels", [1, 2, 10, 30])
def test_the_limit_is_the_quantile_of_the_mean_of_so_many_exponentials(channels: int) -> None:
    quantile = chi2.isf(5e-7, 2 * channels) / (2 * channels)
    assert noise_limit(channels) / FLOOR_SCATTER == pytest.approx(quantile, rel=0.12)


def test_windows_that_fade_are_no_floor_and_windows_of_noise_are() -> None:
    rng = np.random.default_rng(7)
    noise = [window(rng) for _ in range(4)]
    assert not motion_decays(noise, noise_floor_of_windows(noise))
    decay = [window(rng, 3 * np.exp(-0.15 * n * N / RATE) * ringing(rng, 1.0)) for n in range(4)]
    assert motion_decays(decay, noise_floor_of_windows(decay))


@pytest.mark.parametrize("part", [0.005, 0.02, 0.1])
def test_the_residual_is_measured_as_part_of_the_hits_own_motion(floor: NoiseFloor, part: float) -> None:
    rng = np.random.default_rng(8)
    own = ringing(rng, 300.0)
    ratio, line = residual_ratio(window(rng, part * own), window(rng, own)[:, : N // 2], floor)
    assert ratio == pytest.approx(part, rel=0.3)
    assert line * RATE / N == pytest.approx(4.8, abs=0.5)


def test_no_residual_is_zero(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(9)
    own = window(rng, ringing(rng, 300.0))[:, : N // 2]
    assert all(residual_ratio(window(rng), own, floor)[0] == 0 for _ in range(50))


def test_a_few_lines_are_those_of_all(floor: NoiseFloor) -> None:
    rng = np.random.default_rng(10)
    block = window(rng, ringing(rng, 30.0))[:, : N // 2 - 3]
    lines = np.array([1, 9, 10, 11, 700])
    np.testing.assert_allclose(
        amplitude_of_motion(block, N, lines, floor), sensor_motion(block, N, floor)[:, lines], rtol=1e-3
    )
