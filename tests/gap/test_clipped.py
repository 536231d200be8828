"""A cut channel beside sines that only stay long at their top."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.gap.conditioning.records import find_clipped

ROWS, N, RATE, NOISE, FULL_SCALE = 3, 1024, 1000.0, 3e-4, 10.0
STEP = FULL_SCALE / 32768


def record(line: float, volts: float, cut: float, seed: int) -> Block:
    """One sine on three rows, the last of them cut at `cut` volts."""
    rng = np.random.default_rng(seed)
    hz = line / 1.024
    wave = volts * np.cos(2 * np.pi * hz * np.arange(N) / RATE + rng.uniform(0, 2 * np.pi)) * np.ones((ROWS, 1))
    wave += NOISE * rng.standard_normal(wave.shape)
    wave[-1] = np.clip(wave[-1], -cut, cut)
    names = tuple(f"row {i}" for i in range(ROWS))
    counts = np.round(wave / STEP).astype(np.int16)
    return Block(f"s{line}", "sine", 0, RATE, counts, np.full(ROWS, STEP), ("V",) * ROWS, names, 4, "high", hz)


@pytest.mark.parametrize("line", [3, 30, 88, 108])
def test_a_channel_cut_a_little_below_its_peak_is_found_at_every_frequency(line: int) -> None:
    blocks = [record(line, 4.6, 0.94 * 4.6, 1), record(12, 1.0, 0.94 * 4.6, 2)]
    (found,) = find_clipped(blocks, np.full(ROWS, NOISE), np.full(ROWS, FULL_SCALE), 0)
    assert found.row == ROWS - 1
    assert found.volts == pytest.approx(0.94 * 4.6, rel=2e-3)
    assert found.records == (f"s{line}",)


@pytest.mark.parametrize("line", [3, 7.4, 32, 64, 88, 108, 128, 256])
@pytest.mark.parametrize("volts", [0.01, 0.3, 4.6])
@pytest.mark.parametrize("seed", range(3))
def test_no_whole_sine_is_called_cut(line: float, volts: float, seed: int) -> None:
    assert find_clipped([record(line, volts, np.inf, seed)], np.full(ROWS, NOISE), np.full(ROWS, FULL_SCALE), 0) == []


@pytest.mark.parametrize("share", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_channel_full_of_noise_is_not_called_cut(share: float, seed: int) -> None:
    """Its noise reaches from nought to its peaks, so that every sample is as near them as noise may take it."""
    whole = record(32, 0.3, np.inf, seed)
    rng = np.random.default_rng(seed)
    noise = 0.3 * share
    counts = whole.samples.copy()
    counts[-1] += np.round(noise / STEP * rng.standard_normal(N)).astype(np.int16)
    noises = np.array([NOISE, NOISE, noise])
    assert find_clipped([replace(whole, samples=counts)], noises, np.full(ROWS, FULL_SCALE), 0) == []
