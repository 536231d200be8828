"""The checks at every border: what no measurement can hold is rejected, what a poor one holds is not."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.core.array_checks import (
    check_frequencies,
    check_frf,
    check_rate,
    check_signals,
    check_time,
    identical_channels,
)
from modallab.core.errors import DataError
from modallab.signals.faults.whole_channels import constant_channels

NAMES = ("force", "a01", "a02", "a03")
PLACE = "hit.npy"


@pytest.fixture
def samples() -> NDArray[np.float64]:
    return np.random.default_rng(1).normal(size=(4, 256))


def rejected(call: Any, *args: Any, **options: Any) -> str:
    with pytest.raises(DataError) as caught:
        call(*args, **options)
    assert caught.value.where == PLACE
    assert caught.value.remedy
    return str(caught.value)


def test_a_good_record_passes(samples: NDArray[np.float64]) -> None:
    check_signals(samples, NAMES, PLACE, force="force")
    check_signals((1000 * samples).astype(np.int16), NAMES, PLACE, force="force")


def test_every_channel_with_nan_or_infinity_is_named(samples: NDArray[np.float64]) -> None:
    samples[1, 17] = np.nan
    samples[3, :2] = np.inf
    message = rejected(check_signals, samples, NAMES, PLACE)
    assert "channel a01: 1 of 256 samples are NaN or infinite, the first is sample 17" in message
    assert "channel a03: 2 of 256 samples are NaN or infinite, the first is sample 0" in message


def test_a_number_no_bench_can_hold_is_named(samples: NDArray[np.float64]) -> None:
    samples[2, 5] = -1e300
    message = rejected(check_signals, samples, NAMES, PLACE)
    assert "channel a02: 1 of 256 samples are beyond 1e+30, the first is sample 5" in message


def test_a_dead_response_is_a_fault_with_its_value_and_no_reason_to_reject_the_record(
    samples: NDArray[np.float64],
) -> None:
    samples[2] = 0.25
    check_signals(samples, NAMES, PLACE, force="force")
    assert [str(f) for f in constant_channels(samples, NAMES, ())] == [
        "channel a02: dead, all values are 0.25, 256 samples from 0 s on"
    ]


def test_zeros_everywhere_are_reported_as_such() -> None:
    message = rejected(check_signals, np.zeros((4, 256), np.int16), NAMES, PLACE)
    assert "every channel is zero (force, a01, a02, a03): nothing was recorded" in message


def test_a_light_sensor_below_one_count_in_a_record_of_little_motion_is_not_dead() -> None:
    counts = np.random.default_rng(2).integers(-1, 2, size=(4, 256)).astype(np.int16)
    counts[0] = 500 * np.sin(np.arange(256))
    counts[1] = 0
    assert constant_channels(counts.astype(np.float64), NAMES, ()) == ()
    counts[2:] *= 20
    counts[2:] += np.random.default_rng(3).integers(-9, 9, size=(2, 256)).astype(np.int16)
    assert [f.channel for f in constant_channels(counts.astype(np.float64), NAMES, ())] == ["a01"]


def test_a_dead_force_is_an_error_in_any_record() -> None:
    counts = np.random.default_rng(2).integers(-1, 2, size=(4, 256)).astype(np.int16)
    counts[0] = 0
    assert "channel force is dead" in rejected(check_signals, counts, NAMES, PLACE, force="force")


def test_poor_but_living_channels_are_no_errors(samples: NDArray[np.float64]) -> None:
    clipped = np.clip(samples, -0.1, 0.1)
    turned = samples * np.array([[1.0], [-1.0], [1.0], [1.0]])
    swapped = samples[[0, 2, 1, 3]]
    for record in (clipped, turned, swapped, samples * 1e-9, samples + 1e6):
        check_signals(record, NAMES, PLACE, force="force")


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.ones((256, 4)).cumsum(axis=0), "the array looks transposed"),
        (np.ones((3, 256)).cumsum(axis=1), "there are 3 channels, the rig has 4: force, a01, a02, a03"),
        (np.ones(256), "the samples have shape (256,)"),
        (np.ones((4, 0)), "there are no samples"),
        (np.ones((4, 256), complex), "complex numbers, as a spectrum has"),
        (np.full((4, 256), "1"), "values of type <U1"),
        (np.full((4, 256), None), "values of type object"),
    ],
)
def test_arrays_of_the_wrong_shape_or_type_are_rejected(array: NDArray[Any], words: str) -> None:
    assert words in rejected(check_signals, array, NAMES, PLACE)


def test_copies_are_found_and_constant_channels_are_no_copies(samples: NDArray[np.float64]) -> None:
    assert identical_channels(samples, NAMES) == ()
    samples[3] = samples[1]
    assert identical_channels(samples, NAMES) == (("a01", "a03"),)
    samples[1:] = 0.0
    assert identical_channels(samples, NAMES) == ()


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf])
def test_rates_that_are_none_are_rejected(rate: float) -> None:
    assert "the sampling rate is" in rejected(check_rate, rate, PLACE)


@pytest.mark.parametrize("rate", [1000.0, 25600.0, 1651.6129032258063, 65536.0])
def test_the_rate_comes_back_from_its_times(rate: float) -> None:
    times = 3.0 + np.arange(4096) / rate
    assert check_time(times, PLACE) == pytest.approx(rate, rel=1e-9)


def test_a_whole_rate_comes_back_whole_from_rounded_times() -> None:
    times = np.round(np.arange(2048) / 25600, 6)
    assert check_time(times, PLACE, resolution_s=0.5e-6) == 25600.0


def test_a_rate_between_two_whole_ones_is_kept() -> None:
    assert check_time(np.arange(2097) / 2048.5, PLACE) == pytest.approx(2048.5, rel=1e-12)


@pytest.mark.parametrize("lost", [1, 500, 998])
def test_one_lost_sample_is_seen_anywhere(lost: int) -> None:
    times = np.delete(np.arange(1000) / 1000.0, lost)
    assert "the time axis is uneven" in rejected(check_time, times, PLACE)


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (np.arange(10)[::-1] / 10, "the time axis descends"),
        (np.array([0, 0.1, 0.1, 0.2]), "does not ascend: 0.1 s is followed by 0.1 s"),
        (np.array([0, 0.1, np.nan]), "holds nan at place 2"),
        (np.array([1.0]), "has shape (1,)"),
        (np.array([-1e308, 0, 1e308, 1.1e308]), "uneven"),
    ],
)
def test_times_that_are_none_are_rejected(times: NDArray[np.float64], words: str) -> None:
    assert words in rejected(check_time, times, PLACE)


def test_times_with_too_few_digits_are_reported_as_such() -> None:
    times = np.round(np.arange(100) / 25600, 3)
    assert "written too coarsely" in rejected(check_time, times, PLACE, resolution_s=0.5e-3)


def test_frequencies_must_ascend_evenly_from_zero_upwards() -> None:
    lines = np.arange(1, 100) / 1.024
    check_frequencies(lines, PLACE)
    assert "the frequency axis descends" in rejected(check_frequencies, lines[::-1], PLACE)
    assert "begin at -" in rejected(check_frequencies, lines - 5, PLACE)
    uneven = lines[[3, 4, 5, 6, 8, 12]]
    assert "the frequency axis is uneven" in rejected(check_frequencies, uneven, PLACE)
    check_frequencies(uneven, PLACE, even=False)


@pytest.fixture
def frf() -> NDArray[np.complex128]:
    omega = 2 * np.pi * np.arange(1, 65)
    first = 1 / (120.0**2 - omega**2 + 2j * 0.01 * 120 * omega)
    second = 1 / (260.0**2 - omega**2 + 2j * 0.01 * 260 * omega)
    return np.stack([first, first - second])[:, None, :]


def test_a_measured_frf_passes(frf: NDArray[np.complex128]) -> None:
    check_frf(np.arange(1.0, 65.0), frf, ("a01", "a02"), PLACE)


def test_what_is_wrong_with_an_frf_is_named_by_channel(frf: NDArray[np.complex128]) -> None:
    lines, names = np.arange(1.0, 65.0), ("a01", "a02")
    assert "magnitude only" in rejected(check_frf, lines, np.abs(frf), names, PLACE)
    half = frf.copy()
    half[1] = np.abs(half[1])
    assert "channel a02: its FRF is magnitude only" in rejected(check_frf, lines, half, names, PLACE)
    half[1] = frf[1].real
    assert "channel a02: its FRF is real at every line" in rejected(check_frf, lines, half, names, PLACE)
    half[1], half[0, 0, 3] = 0, np.nan
    message = rejected(check_frf, lines, half, names, PLACE)
    assert "channel a01: 1 lines of its FRF are NaN" in message
    assert "channel a02: its FRF is zero" in message
    assert "the FRF has shape (64, 1, 2)" in rejected(check_frf, lines, frf.T, names, PLACE)


def test_a_single_line_may_be_real(frf: NDArray[np.complex128]) -> None:
    values = frf.copy()
    values[..., 0] = values[..., 0].real
    check_frf(np.arange(64.0), values, ("a01", "a02"), PLACE)
