"""Mains hum beside what only looks like it."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.gap.conditioning.hum import find_hum, without_hum

ROWS, N, RATE, NOISE = 5, 1024, 1000.0, 3e-4
STEP = 10 / 32768


def record(k: int, volts: np.ndarray, hz: float, rng: np.random.Generator, clock: float = 0.0, line: int = 0) -> Block:
    t = np.arange(N) / (RATE * (1 + clock))
    drive = (line or 3 * k + 3) / 1.024
    wave = 0.2 * np.cos(2 * np.pi * drive * t) + volts[:, None] * np.cos(2 * np.pi * hz * t + rng.uniform(0, 2 * np.pi))
    counts = np.round((wave + NOISE * rng.standard_normal(wave.shape)) / STEP).astype(np.int16)
    names = tuple(f"row {i}" for i in range(ROWS))
    return Block(f"s{k}", "sine", k, RATE, counts, np.full(ROWS, STEP), ("V",) * ROWS, names, 4, "low", drive)


def records(size, hz: float, seed: int = 1, clock: float = 0.0) -> list[Block]:
    rng = np.random.default_rng(seed)
    return [record(k, size(k, rng), hz, rng, clock) for k in range(20)]


@pytest.mark.parametrize("hz", [50.0, 60.0])
@pytest.mark.parametrize("volts", [2e-4, 2e-3, 0.05])
def test_hum_is_found_with_its_amplitude_on_every_row(volts: float, hz: float) -> None:
    each = volts * (0.5 + 0.1 * np.arange(ROWS))
    found = find_hum(records(lambda _k, _rng: each, hz), np.full(ROWS, NOISE), 0)
    assert found is not None
    assert found.hz == hz
    assert found.volts == pytest.approx(each, abs=1.5e-5)


def test_a_floor_that_shakes_at_the_mains_frequency_is_no_hum() -> None:
    # A base under a transformer: steady, on every accelerometer, nothing on the force.
    still = np.array([0.0, 0.02, 0.02, 0.03, 0.03])
    assert find_hum(records(lambda _k, _rng: still, 60.0), np.full(ROWS, NOISE), 0) is None


@pytest.mark.parametrize("seed", range(4))
def test_what_is_on_every_row_but_changes_from_record_to_record_is_no_hum(seed: int) -> None:
    def random(_k: int, rng: np.random.Generator) -> np.ndarray:
        return np.full(ROWS, 0.02 * np.hypot(*rng.standard_normal(2)))

    assert find_hum(records(random, 50.0, seed), np.full(ROWS, NOISE), 0) is None


@pytest.mark.parametrize("seed", range(4))
def test_noise_alone_is_no_hum(seed: int) -> None:
    assert find_hum(records(lambda _k, _rng: np.zeros(ROWS), 50.0, seed), np.full(ROWS, NOISE), 0) is None


def test_the_force_may_stand_in_another_row() -> None:
    each = np.array([0.02, 0.02, 0.02, 0.02, 0.0])
    blocks = records(lambda _k, _rng: each, 50.0)
    assert find_hum(blocks, np.full(ROWS, NOISE), force=4) is None
    assert find_hum(blocks, np.full(ROWS, NOISE), force=0) is not None


def test_what_is_left_without_the_hum_is_noise() -> None:
    each = 0.03 * (0.5 + 0.1 * np.arange(ROWS))
    blocks = records(lambda _k, _rng: each, 50.0)
    found = find_hum(blocks, np.full(ROWS, NOISE), 0)
    assert found is not None
    again = [without_hum(b, found) for b in blocks]
    assert find_hum(again, np.full(ROWS, NOISE), 0) is None
    left = again[0].samples * STEP
    spectrum = np.abs(np.fft.rfft(left * np.hanning(N), axis=1))[:, 51]
    assert spectrum.max() < 6 * NOISE * np.sqrt(0.375 * N)


@pytest.mark.parametrize("clock", [-0.025, 0.0182])
def test_hum_stands_elsewhere_where_the_converters_clock_is_off(clock: float) -> None:
    each = 0.03 * (0.5 + 0.1 * np.arange(ROWS))
    blocks = records(lambda _k, _rng: each, 50.0, clock=clock)
    found = find_hum(blocks, np.full(ROWS, NOISE), 0)
    assert found is not None
    assert (found.hz, found.seen_hz) == (50.0, pytest.approx(50.0 / (1 + clock), abs=0.01))
    assert found.volts == pytest.approx(each, rel=2e-3)
    # Also from the records whose drive stands beside it; within half a line no block separates the two.
    t = np.arange(N) / (RATE * (1 + clock))
    for block in blocks:
        if abs(block.frequency_hz - 50.0) < 0.5:
            continue
        left = without_hum(block, found).samples * STEP
        drive = 2 * np.pi * block.frequency_hz * t
        basis = np.column_stack([np.cos(drive), np.sin(drive), np.ones(N)])
        left = left - (basis @ np.linalg.lstsq(basis, left.T, rcond=None)[0]).T
        assert np.sqrt(np.mean(left**2)) < 2 * NOISE, block.name


@pytest.mark.parametrize("clock", [-3.7e-4, 1e-4])
def test_hum_beside_the_drive_is_taken_out_where_the_clock_is_a_little_off(clock: float) -> None:
    # A hundredth of a line off, a drive leaves as much of itself at the mains as weak hum is.
    each = 8e-4 * (0.5 + 0.1 * np.arange(ROWS))
    blocks = records(lambda _k, _rng: each, 50.0, clock=clock)
    found = find_hum(blocks, np.full(ROWS, NOISE), 0)
    assert found is not None
    beside = record(20, each, 50.0, np.random.default_rng(2), clock, line=50)
    t = np.arange(N) / (RATE * (1 + clock))
    left = without_hum(beside, found).samples * STEP
    turns = 2 * np.pi * np.outer([beside.frequency_hz, 50.0], t)
    basis = np.vstack([np.cos(turns), np.sin(turns), np.ones(N)])
    amplitudes = np.linalg.lstsq(basis.T, left.T, rcond=None)[0][[1, 3]]
    assert np.hypot(*amplitudes).mean() < 0.4 * each.mean()


def test_a_noisy_row_decides_neither_where_the_hum_stands_nor_its_phase() -> None:
    each, noise = 8e-4 * (0.5 + 0.1 * np.arange(ROWS)), np.full(ROWS, NOISE)
    noise[3] *= 1000
    rng = np.random.default_rng(3)
    blocks = [record(k, each, 50.0, rng) for k in range(20)]
    loud = [replace(b, samples=b.samples.astype(float)) for b in blocks]
    for b in loud:
        b.samples[3] += noise[3] / STEP * rng.standard_normal(N)
    found = find_hum(loud, noise, 0)
    assert found is not None
    assert found.seen_hz == 50.0
    for before, after in zip(blocks, (without_hum(b, found) for b in loud), strict=True):
        if abs(before.frequency_hz - 50.0) > 5.0:
            others = [row for row in range(ROWS) if row != 3]
            spectrum = np.abs(np.fft.rfft(after.samples[others] * STEP * np.hanning(N), axis=1))[:, 51]
            assert spectrum.max() < 6 * NOISE * np.sqrt(0.375 * N)


def test_a_drive_of_less_than_a_period_says_nothing_of_where_drives_stand() -> None:
    each = 0.03 * (0.5 + 0.1 * np.arange(ROWS))
    blocks = records(lambda _k, _rng: each, 50.0)
    slow = replace(blocks[0], name="slow", frequency_hz=0.3)
    found = find_hum([slow, *blocks], np.full(ROWS, NOISE), 0)
    assert found is not None
    assert found.ratio == pytest.approx(1.0, abs=1e-5)
