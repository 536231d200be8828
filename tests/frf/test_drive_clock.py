"""Blocks of a periodic drive whose clock runs otherwise than the converter's."""

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.frf.periodic_drive import clock_of_drive, resample_to_drive_clock
from modallab.signals.signals import Signals

N, RATE_HZ = 1024, 1024.0
LINES = np.arange(3, 200, 2)


def played(clock: float, blocks: int = 4) -> list[Signals]:
    """Odd lines of equal size, in blocks that follow each other."""
    t = np.arange(blocks * N) / N * (1 + clock)
    phase = np.random.default_rng(1).uniform(0, 2 * np.pi, LINES.size)
    force = np.cos(2 * np.pi * LINES[:, None] * t + phase[:, None]).sum(axis=0).reshape(blocks, N)
    return [
        Signals(
            forces=f, responses=3 * f[None], rate_hz=RATE_HZ, outputs=("a",),
            block=Block(
                name=f"b{k}", test="pseudo-random", order=k, rate_hz=RATE_HZ, samples=np.zeros((2, N)),
                scale=np.ones(2), units=("N", "m/s^2"), channels=("force", "a"), first_sample=k * N,
            ),
        )
        for k, f in enumerate(force)
    ]  # fmt: skip


def leaked(signals: list[Signals]) -> float:
    """Rms of the even lines over that of the odd ones."""
    power = np.mean([np.abs(np.fft.rfft(s.responses[0])) ** 2 for s in signals], axis=0)
    return float(np.sqrt(power[4:200:2].sum() / power[3:200:2].sum()))


@pytest.mark.parametrize("clock", [-20e-6, 150e-6])
def test_no_line_leaks_into_another_once_the_blocks_are_cut_by_the_drives_clock(clock: float) -> None:
    signals = played(clock)
    assert clock_of_drive(signals, LINES) == pytest.approx(clock, rel=1e-3)
    assert leaked(resample_to_drive_clock(signals, LINES)) < 0.02 * leaked(signals)


def test_with_one_clock_the_blocks_stay_as_they_are() -> None:
    signals = played(0.0)
    assert all(a is b for a, b in zip(resample_to_drive_clock(signals, LINES), signals, strict=True))
