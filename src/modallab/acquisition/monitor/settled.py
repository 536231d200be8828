"""Whether the beam is at rest: by its level, and line by line, since a slow mode hides below the noise.

The level alone is not enough. A residual of the first mode at half the noise's rms raises the rms by 12 %, and with
0.3 % damping it rings on for half a minute. Over a window of N samples a tone of amplitude a in noise of rms sigma
stands in its Hann line with the power a^2 N / (6 sigma^2) relative to the noise, and is found far below it.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

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

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class Floor:
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
        power: (lines,) of all lines, as `line_power`.
    """

    level: float
    line: int
    excess: float
    power: Real

    @property
    def settled(self) -> bool:
        """Whether the beam rests, as far as this window shows."""
        return self.level <= LEVEL_FACTOR and self.excess < 1

    def facts(self, line_hz: float) -> dict[str, float | str]:
        """For the catalogue; `line_hz` is the width of a line."""
        return {
            "settled_before": "yes" if self.settled else "no",
            "motion_level": self.level,
            "motion_excess": self.excess,
            "motion_line_hz": self.line * line_hz,
        }


def noise_limit(channels: int) -> float:
    """What noise of mean power 1, averaged over channels, reaches in one line of about a million (Wilson-Hilferty)."""
    spread = 1 / (9 * channels)
    return float((1 - spread + FALSE_ALARM_SIGMA * np.sqrt(spread)) ** 3) * FLOOR_SCATTER


def centred(window: Real) -> Real:
    """The (channels, n) window without its mean."""
    return window - window.mean(axis=1, keepdims=True)


def line_power(window: Real, rms: Real) -> Real:
    """(lines,) Hann power of a (channels, n) window, in units of the noise power, averaged over channels.

    Line 0 is the mean and left at 0.
    """
    n = window.shape[1]
    hann, energy = _hann(n)
    spectrum = np.fft.rfft(centred(window) * hann, axis=1)[:, : int(USED_BAND * n)]
    power = (np.abs(spectrum) ** 2).T @ (1 / (rms**2 * energy)) / window.shape[0]
    power[0] = 0
    return power


@lru_cache(maxsize=16)
def _hann(n: int) -> tuple[Real, float]:
    """The window of n samples and its sum of squares; every look of a test has the same."""
    hann = np.hanning(n + 1)[:-1]
    hann.flags.writeable = False
    return hann, float((hann**2).sum())


def floor_of(windows: list[Real], *, counts: bool = True) -> Floor:
    """The floor from (channels, n) windows at rest, as delivered.

    A channel's noise may be less than one count: then the count's rounding, 1 / sqrt(12), is its floor. What a device
    delivers as real numbers has no count; there a volt is no rounding.
    """
    level = np.array([centred(window).std(axis=1) for window in windows])
    rms = np.maximum(np.median(level, axis=0), 1 / np.sqrt(12) if counts else 1e-12)
    power = np.mean([line_power(window, rms) for window in windows], axis=0)
    # Neighbours know the noise better than one line alone; a steady tone, such as the mains', keeps its own.
    smooth = _neighbours(power)
    return Floor(rms, np.maximum(np.where(power > TONE_FACTOR * smooth, power, smooth), 1e-3))


def _neighbours(power: Real) -> Real:
    counted = np.ones(len(power))
    counted[0] = 0  # line 0 is the mean, which was taken out
    kernel = np.ones(SMOOTH_LINES)
    return np.convolve(power, kernel, mode="same") / np.convolve(counted, kernel, mode="same")


def fading(windows: list[Real], floor: Floor) -> bool:
    """Whether the windows a floor was taken from hold a motion that dies away: then it was no rest."""
    powers = [line_power(window, floor.rms) for window in windows]
    half = len(windows) // 2
    early, late = np.mean(powers[:half], axis=0), np.mean(powers[half:], axis=0)
    strong = early > noise_limit(len(floor.rms)) * np.median(floor.lines)
    return bool((late[strong] < 0.8 * early[strong]).any())


def check_settled(window: Real, floor: Floor) -> SettledCheck:
    """What a (channels, n) window, of the floor's n, says about the beam."""
    level = float((centred(window).std(axis=1) / floor.rms).max())
    power = line_power(window, floor.rms)
    excess = power / (floor.lines * noise_limit(len(floor.rms)))
    line = int(np.argmax(excess))
    return SettledCheck(level, line, float(excess[line]), power)


def residual_ratio(before: Real, block: Real, floor: Floor) -> tuple[float, int]:
    """How large the motion before a hit is beside the hit's own, and in which line it is largest.

    Args:
        before: (channels, n) window that ended at the hit.
        block: (channels, m <= n) of the hit.
        floor: of the same n.

    Returns:
        The largest ratio of amplitudes over the peaks in which `before` stands well out of the noise; 0 if none does.
    """
    moves, lines = ringing_lines(line_power(before, floor.rms), before.shape[1], floor)
    if lines.size == 0:
        return 0.0, 0
    return largest_ratio(moves, lines, own_motion(block, before.shape[1], floor))


def ringing_lines(power: Real, n: int, floor: Floor) -> tuple[Real, NDArray[np.int64]]:
    """(peaks,) amplitudes, in noise rms, of what stands well out of the noise in a window of n samples, and lines.

    `power` is its `line_power`.
    """
    limit = np.maximum(RINGING_EXCESS * floor.lines * noise_limit(len(floor.rms)), PEAK_RANGE * power.max())
    peaks = np.flatnonzero((power > limit) & (power == _highest(power, PEAK_LINES)))
    # A tone of amplitude a has the line power a^2 (sum w)^2 / (4 sum w^2) = a^2 n / 6.
    return np.sqrt((power - floor.lines)[peaks] * 6 / n), peaks


def own_motion(block: Real, n: int, floor: Floor) -> Real:
    """(lines,) amplitudes, in noise rms, of a hit's (channels, m <= n) block on the lines of a window of n samples."""
    spectrum = 2 * np.abs(np.fft.rfft(centred(block), n, axis=1)) / block.shape[1]
    return np.sqrt((spectrum**2).T @ (1 / floor.rms**2) / len(floor.rms))


def largest_ratio(moves: Real, lines: NDArray[np.int64], own: Real) -> tuple[float, int]:
    """The largest ratio of ringing amplitudes to a hit's `own_motion`, and its line."""
    ratio = moves / np.maximum(_highest(own, 1)[lines], 1e-300)
    worst = int(np.argmax(ratio))
    return float(ratio[worst]), int(lines[worst])


def _highest(values: Real, reach: int) -> Real:
    highest = values.copy()
    for off in range(1, reach + 1):
        np.maximum(highest[off:], values[:-off], out=highest[off:])
        np.maximum(highest[:-off], values[off:], out=highest[:-off])
    return highest
