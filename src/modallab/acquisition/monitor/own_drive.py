"""Whether each force follows the drive of its own shaker, or that of another: two plugs may have changed places."""

from collections.abc import Sequence

import numpy as np

from modallab.bench.protocol import Waveform
from modallab.core.arrays import Complex128, Real

TOGETHER = 9
"""Lines over which a force and its drive are one factor: whatever a converter delays turns them by little."""

MUCH_MORE = 2.0
"""Times its own drive's coherence. Drives without relation have 1 / TOGETHER, bursts, whose lines go together, 0.4."""


def drive_followed_by_each_force(forces: Real, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> list[int]:
    """Which of the drives each force follows: its own, unless it follows another much more.

    Chirps are alike in one wave, whichever shaker plays them: of these each force follows its own.

    Args:
        forces: (shakers, n) in N, in the order of the waves.
        waves: what each shaker plays.
        first_s: of the samples, since the waves began.
        rate_hz: of the samples.
    """
    window = np.hanning(forces.shape[1])
    times = first_s + np.arange(forces.shape[1]) / rate_hz
    drives = np.stack([wave.at(times) for wave in waves])
    f, d = (np.fft.rfft((rows - rows.mean(axis=1, keepdims=True)) * window) for rows in (forces, drives))
    driven = np.flatnonzero(np.sum(np.abs(d) ** 2, axis=0) > 0.01 * np.max(np.sum(np.abs(d) ** 2, axis=0)))
    alike = _coherence(f[:, driven], d[:, driven])
    most = alike.argmax(axis=1)
    own = np.diagonal(alike)
    clear = alike.max(axis=1) > MUCH_MORE * own
    return [int(other) if sure else n for n, (other, sure) in enumerate(zip(most, clear, strict=True))]


def _coherence(forces: Complex128, drives: Complex128) -> Real:
    """(forces, drives) mean over the lines of what each drive explains of each force in TOGETHER lines."""
    count = forces.shape[1] // TOGETHER
    f, d = (rows[:, : count * TOGETHER].reshape(len(rows), count, TOGETHER) for rows in (forces, drives))
    cross = np.abs(np.einsum("fct,dct->fdc", f, d.conj())) ** 2
    powers = np.sum(np.abs(f) ** 2, axis=2)[:, None] * np.sum(np.abs(d) ** 2, axis=2)[None]
    return np.mean(cross / np.maximum(powers, np.finfo(float).tiny), axis=2)
