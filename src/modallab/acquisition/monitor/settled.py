"""Whether the beam is at rest: by its level, and line by line, since a slow mode hides below the noise.

The level alone is not enough. A residual of the first mode at half the noise's rms raises the rms by 12 %, and with
0.3 % damping it rings on for half a minute. Over a window of N samples a tone of amplitude a in noise of rms sigma
stands in its Hann line with the power a^2 N / (6 sigma^2) relative to the noise, and is found far below it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.signals.transform import spectrum

LEVEL_FACTOR = 1.5
"""A channel whose rms is above this many times its floor is not at rest."""

FALSE_ALARM_SIGMA = 4.9
"""A line counts from a noise probability of 5e-7 on: one false alarm in about a thousand windows of 2000 lines."""

FLOOR_SCATTER = 1.1
"""The floor itself is known to some 5 % only, from a few windows and neighbouring lines."""

SMOOTH_LINES = 9
TONE_FACTOR = 1.8
"""A line so far above its neighbours, over ten channels and four windows, is a tone and no noise."""

RINGING_EXCESS = 2.0
"""A line that rejects a hit stands so far above what noise may reach: in a line where the hit itself excites little,
a chance excess of the noise would else look like a large part of it."""

PEAK_LINES = 3
PEAK_RANGE = 0.01
"""A peak is the highest of so many lines on either side, and at most 20 dB below the highest of all: what is beside or
below it is its skirt, and no motion of its own, but may be large where the hit excites little."""

USED_BAND = 0.4
"""Lines up to this fraction of the rate; above it the anti-alias filter falls."""

Single = NDArray[np.float32]
Window = NDArray[Any]
"""(channels, n) as delivered."""


@dataclass(frozen=True, eq=False, slots=True)
class NoiseFloor:
    """The noise of the chain while the beam rests.

    Attributes:
        rms: (motion channels,) in counts.
        lines: (lines,) power by line, averaged over channels, 1 for white noise; line k is k / window duration.
    """

    rms: Real
    lines: Real


@dataclass(frozen=True, eq=False, slots=True)
class SettledCheck:
    """What one window says.

    Attributes:
        level: largest rms of a channel over its floor.
        line: the line that stands out most, k of k / window duration.
        excess: its power over what noise may reach; below 1 nothing stands out.
    """

    level: float
    line: int
    excess: float

    @property
    def is_settled(self) -> bool:
        """Whether the beam rests, as far as this window shows."""
        return self.level <= LEVEL_FACTOR and self.excess < 1

    def facts(self, line_hz: float) -> dict[str, float | str]:
        """For the catalogue; `line_hz` is the width of a line."""
        return {
            "settled_before": "yes" if self.is_settled else "no",
            "motion_level": self.level,
            "motion_excess": self.excess,
            "motion_line_hz": self.line * line_hz,
        }


def noise_limit(channels: int) -> float:
    """What noise of mean power 1, averaged over channels, reaches in one line of about a million (Wilson-Hilferty)."""
    spread = 1 / (9 * channels)
    return float((1 - spread + FALSE_ALARM_SIGMA * np.sqrt(spread)) ** 3) * FLOOR_SCATTER


@dataclass(frozen=True, eq=False, slots=True)
class WindowLevels:
    """What is seen in one window; made once, since it is the dearest step of many channels at a high rate.

    Attributes:
        rms: (channels,) in counts, without the mean.
        power: (lines,) Hann power in units of the noise power, averaged over channels; line 0, the mean, is left at 0.
        count: samples of the window.
    """

    rms: Real
    power: Real
    count: int

    @classmethod
    def of(cls, window: Window, noise_rms: Real) -> Self:
        """Of a (channels, n) window, compared with noise of (channels,) rms counts."""
        n = window.shape[1]
        taper, energy = _hann_window(n)
        level, power = np.empty(len(window)), np.zeros(int(USED_BAND * n))
        for i, (row, rms) in enumerate(zip(without_mean(window), noise_rms, strict=True)):
            level[i] = _rms(row)
            power += _power_of_lines(spectrum(row * taper)[: power.size]) / rms**2
        power /= energy * len(window)
        power[0] = 0
        return cls(level, power, n)


def without_mean(window: Window) -> Iterator[Single]:
    """Each channel of a (channels, n) window without its mean.

    One at a time: what stays in the processor's cache is gone through several times as fast as all channels at once.
    Single precision holds what moves to one part in ten million; the mean, which may be far larger, is taken off first.
    """
    return ((row - row.mean(dtype=np.float64)).astype(np.float32) for row in window)


def rms_of(window: Window) -> Real:
    """(channels,) rms of a (channels, n) window, without the mean."""
    return np.array([_rms(row) for row in without_mean(window)], np.float64)


def _rms(row: Single) -> float:
    return float(np.sqrt(np.dot(row, row) / row.size))


@lru_cache(maxsize=16)
def _hann_window(n: int) -> tuple[Single, float]:
    """The Hann window of n samples and its sum of squares: every look of a test has the same."""
    hann = np.hanning(n + 1)[:-1]
    taper = hann.astype(np.float32)
    taper.flags.writeable = False
    return taper, float((hann**2).sum())


def _power_of_lines(spectrum: NDArray[np.complexfloating]) -> NDArray[np.floating]:
    return spectrum.real**2 + spectrum.imag**2


def noise_floor_of_windows(windows: list[Window], *, counts: bool = True) -> NoiseFloor:
    """The floor from (channels, n) windows at rest, as delivered.

    A channel's noise may be less than one count: then the count's rounding, 1 / sqrt(12), is its floor. What a device
    delivers as real numbers has no count; there a volt is no rounding.
    """
    level = np.array([rms_of(window) for window in windows])
    rms = np.maximum(np.median(level, axis=0), 1 / np.sqrt(12) if counts else 1e-12)
    power = np.mean([WindowLevels.of(window, rms).power for window in windows], axis=0)
    # Neighbours know the noise better than one line alone; a steady tone, such as the mains', keeps its own.
    smooth = _neighbours(power)
    return NoiseFloor(rms, np.maximum(np.where(power > TONE_FACTOR * smooth, power, smooth), 1e-3))


def _neighbours(power: Real) -> Real:
    counted = np.ones(len(power))
    counted[0] = 0  # line 0 is the mean, which was taken out
    kernel = np.ones(SMOOTH_LINES)
    return np.convolve(power, kernel, mode="same") / np.convolve(counted, kernel, mode="same")


def motion_decays(windows: list[Window], floor: NoiseFloor) -> bool:
    """Whether the windows a floor was taken from hold a motion that dies away: then it was no rest."""
    powers = [WindowLevels.of(window, floor.rms).power for window in windows]
    half = len(windows) // 2
    early, late = np.mean(powers[:half], axis=0), np.mean(powers[half:], axis=0)
    strong = early > noise_limit(len(floor.rms)) * np.median(floor.lines)
    return bool((late[strong] < 0.8 * early[strong]).any())


def check_settled(look: WindowLevels, floor: NoiseFloor) -> SettledCheck:
    """What a window, of the floor's length, says about the beam."""
    excess = look.power / (floor.lines * noise_limit(len(floor.rms)))
    line = int(np.argmax(excess))
    return SettledCheck(float((look.rms / floor.rms).max()), line, float(excess[line]))


def lines_above_noise(look: WindowLevels, floor: NoiseFloor) -> tuple[Real, NDArray[np.int64]]:
    """(peaks,) amplitudes, in noise rms, of what stands well out of the noise in a window, and their lines."""
    power = look.power
    limit = np.maximum(RINGING_EXCESS * floor.lines * noise_limit(len(floor.rms)), PEAK_RANGE * power.max())
    peaks = np.flatnonzero((power > limit) & (power == _highest_nearby(power, PEAK_LINES)))
    # A tone of amplitude a has the line power a^2 (sum w)^2 / (4 sum w^2) = a^2 n / 6.
    return np.sqrt((power - floor.lines)[peaks] * 6 / look.count), peaks


def sensor_motion(block: Window, n: int, floor: NoiseFloor) -> Single:
    """(channels, lines) amplitudes, in noise rms, of a hit's (channels, m) block on the lines of a window of n samples.

    Lines go as far as those of a window's power.
    """
    found = np.empty((len(block), int(USED_BAND * n)), np.float32)
    for row, moves, rms in zip(found, without_mean(block), floor.rms, strict=True):
        row[:] = np.abs(spectrum(moves, n)[: row.size]) * (2 / (block.shape[1] * rms))
    return found


def amplitude_of_motion(block: Window, n: int, lines: NDArray[np.int64], floor: NoiseFloor) -> Single:
    """As `sensor_motion`, at a few lines only: (channels, lines), in far less time than a transform of all."""
    step = int(np.sqrt(block.shape[1]))
    turns = -2j * np.pi * lines / n
    within = np.exp(np.outer(np.arange(step), turns)).astype(np.complex64).view(np.float32)
    along = np.exp(np.outer(np.arange(-(-block.shape[1] // step)) * step, turns)).astype(np.complex64)
    padded, found = np.zeros(along.shape[0] * step, np.float32), np.empty((len(block), lines.size), np.float32)
    for row, moves, rms in zip(found, without_mean(block), floor.rms, strict=True):
        padded[: moves.size] = moves
        parts = (padded.reshape(-1, step) @ within).view(np.complex64)
        row[:] = np.abs(np.sum(parts * along, axis=0)) * (2 / (moves.size * rms))
    return found


def mean_sensor_motion(sensors: Single) -> Real:
    """(lines,) of `sensor_motion`, the root of the mean square over channels."""
    return np.sqrt(np.mean([row.astype(np.float64) ** 2 for row in sensors], axis=0))


def largest_ratio(moves: Real, lines: NDArray[np.int64], own: Real) -> tuple[float, int]:
    """Largest ringing over a hit's `mean_sensor_motion`, at or beside its line, and the line; 0 if none rings.

    Args:
        moves: (peaks,) amplitudes of what rings.
        lines: (peaks,) where.
        own: (lines,) of all lines, or (3, peaks) of those below, at and above.
    """
    if lines.size == 0:
        return 0.0, 0
    beside = _highest_nearby(own, 1)[lines] if own.ndim == 1 else own.max(axis=0)
    ratio = moves / np.maximum(beside, 1e-300)
    worst = int(np.argmax(ratio))
    return float(ratio[worst]), int(lines[worst])


def _highest_nearby(values: Real, reach: int) -> Real:
    highest = values.copy()
    for off in range(1, reach + 1):
        np.maximum(highest[off:], values[:-off], out=highest[off:])
        np.maximum(highest[:-off], values[off:], out=highest[:-off])
    return highest
