"""The samples of one burst as they come, averaged down, with the two windows that each look compares.

In a rise, or while two motions beat, no channel goes on as it did a moment ago, and what another channel should read
is no more certain. But channels keep moving together in the few shapes in which they have moved so far in the burst and
before it. With the second moments C of that motion, x' inv(C) x is small for what keeps to these shapes and large for
what leaves them (the squared distance of Mahalanobis). Where a window leaves them, and keeps to them far better
once two of its channels are exchanged, these two are exchanged. A new shape, such as a mode that is only now
excited, is not corrected by an exchange.
"""

from itertools import combinations
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.rest_noise import RepetitionCounter, RestNoise, clipped_channels
from modallab.acquisition.monitor.tone_prediction import PredictedWindow, predict_later_window, tone_basis
from modallab.bench.protocol import Burst
from modallab.core.arrays import Real
from modallab.storage.samples import Samples

BETTER = 16.0
"""An exchange must explain the window so many times better: amplitudes four times."""

LEAVES = 50.0
"""Mean square, over what the channels moved before or their noise, from which on a window leaves the shapes."""

LOOKS = 2
"""In so many looks in a row."""


class ExchangedChannels:
    """Learns the shapes of one burst, and holds each window against them."""

    def __init__(self, rest: Real, noise: Real) -> None:
        """Learn from the (channels, n) rest before the burst, whose noise is (channels,) rms, all in one unit."""
        self._noise, self._offset = np.diag(noise**2), rest.mean(axis=1, keepdims=True)
        self._moments = np.zeros((len(noise), len(noise)))
        self._count = 0
        self._suspect: tuple[int, int] | None = None
        self._looks = 0
        self.add_older_samples(rest)

    def add_older_samples(self, values: Real) -> None:
        """Take in (channels, n) samples that are older than the window looked at."""
        moves = values - self._offset
        self._moments += moves @ moves.T
        self._count += moves.shape[1]

    def consistent_with_shapes(self, learned: Real, latest: Real) -> tuple[NDArray[np.bool_], Real]:
        """Whether looks one after another keep to the shapes, (looks,), and the moments each adds to them.

        Args:
            learned: (looks, channels, n) what each look learns first.
            latest: (looks, channels, m) the window it looks at.
        """
        moves = learned - self._offset
        moments = moves @ np.swapaxes(moves, 1, 2)
        count = self._count + learned.shape[2] * np.arange(1, len(learned) + 1)
        known = (self._moments + np.cumsum(moments, axis=0)) / count[:, None, None]
        now = latest - self._offset
        seconds = now @ np.swapaxes(now, 1, 2) / now.shape[2]
        own = np.sum(np.linalg.inv(known + self._noise) * seconds, axis=(1, 2))
        return own < LEAVES * learned.shape[1], moments

    def add_moments(self, moments: Real, count: int) -> None:
        """Take in the (channels, channels) moments of `count` samples, and that the look kept to the shapes."""
        self._moments += moments
        self._count += count
        self._suspect, self._looks = None, 0

    def find_exchanged(self, values: Real) -> tuple[int, int] | None:
        """The two channels that are exchanged, if a (channels, n) window is the last of several that say so."""
        found = self._exchanged(values)
        self._looks = self._looks + 1 if found is not None and found == self._suspect else int(found is not None)
        self._suspect = found
        return found if self._looks >= LOOKS else None

    def _exchanged(self, values: Real) -> tuple[int, int] | None:
        moves = values - self._offset
        size = len(moves)
        now = moves @ moves.T / moves.shape[1]
        away = np.linalg.inv(self._moments / max(self._count, 1) + self._noise)
        own = float(np.sum(away * now))
        if own < LEAVES * size:
            return None
        best, pair = own, None
        for one, other in combinations(range(size), 2):
            order = np.arange(size)
            order[[one, other]] = other, one
            exchanged = float(np.sum(away * now[np.ix_(order, order)]))
            if exchanged < best:
                best, pair = exchanged, (one, other)
        return pair if best < own / BETTER else None


HOP_S = 0.02
"""Between two looks, on a grid from the burst's start: what is found does not depend on how it was read."""

EARLIER_S = 0.1
"""Length of the earlier window, or one period of the drive if that is longer."""

GAP_S = 0.06
"""Between the two windows, three hops: so many looks find a fault in all of the later one, and in none of the other."""

LATER_S = 0.05
LATER_PERIODS = 0.4
WEAK_LATER_S = 0.14
"""Length of the later window, in a low tone longer; the longest is also for tones that are weak beside the noise."""

WEAK_EARLIER_S = 0.5
"""Length of the earlier window for these: long enough that two tones of a structure that beat do not pass for one."""

LEAST_RATE_HZ = 1000.0
SAMPLES_PER_PERIOD = 32
"""What is looked at is averaged down to a rate not far above both, so that a look takes the same time at any rate."""

DRIVEN = 1e-6
"""Part of its amplitude from which on there is any drive."""

MOST_SAMPLES = 2000
"""Longest window, in averaged samples; above 600 Hz the windows get shorter for it."""


class BurstWindows:
    """The samples of one burst as they come, averaged down, with the two windows of each look."""

    def __init__(
        self, burst: Burst, start: int, rate_hz: float, rest: Samples, volts: Real, noise: RestNoise, unseen: int
    ) -> None:
        self.burst, self.noise = burst, noise
        self.repetition = RepetitionCounter(len(volts))
        self.tone: NDArray[np.complex128] | None = None
        self.gone = np.zeros(len(volts), dtype=np.int64)
        self._step = max(1, int(rate_hz // max(SAMPLES_PER_PERIOD * burst.frequency_hz, LEAST_RATE_HZ)))
        self._dt = self._step / rate_hz
        self._volts = volts[:, None]
        # Times count from the burst's start; samples before it, which are still to come, are passed over.
        self._skip = start - unseen
        self._early_s = max(-self._skip, 0) / rate_hz
        self._rest: Real = np.zeros((len(volts), 0))
        self._kept: Real = np.zeros((len(volts), 0))
        self._drive: Real = np.zeros((0, 3))
        self._first = 0
        self._raw: Samples = rest[:, :0]
        self._raw_count = ceil(max(EARLIER_S, 1 / burst.frequency_hz) * rate_hz)
        self.hop = 0
        self.earlier = self._whole_periods(EARLIER_S)
        self.gap = round(GAP_S / self._dt)
        self.later_s = min(max(LATER_S, LATER_PERIODS / burst.frequency_hz), WEAK_LATER_S)
        averaged = _averaged(rest * self._volts, self._step)
        rounding = np.maximum(noise.step * volts, np.finfo(float).tiny) / np.sqrt(12 * self._step)
        self.noise_v = np.maximum(averaged.std(axis=1), rounding)
        # What has not rung down, or hums, must not pass for a noise that a lost tone falls back to.
        self.white_v = np.minimum(self.noise_v, np.maximum(noise.rms * volts / np.sqrt(self._step), rounding))
        self.sigma_v = self.noise_v * np.sqrt(2 / self.earlier)
        self.places = ExchangedChannels(averaged, self.white_v)

    @property
    def envelope_earlier(self) -> float:
        """Of the drive in the middle of the earlier window, 0 to 1."""
        middle = self._at(self.hop * HOP_S) - self.count(self.later_s) - self.gap - self.earlier // 2
        return float(np.hypot(*self._drive[middle - self._first, 1:]))

    def are_steady(self, later_s: float | None = None, earlier_s: float = EARLIER_S) -> bool:
        """Whether both windows of this look lie past the rise and before the fall."""
        end_s = self.hop * HOP_S
        later_s = self.later_s if later_s is None else later_s
        begins_s = end_s - (self._whole_periods(earlier_s) + self.gap) * self._dt - later_s
        return begins_s >= self.burst.ramp_s and end_s <= self.burst.duration_s - self.burst.ramp_s

    def cut_off(self, samples: Samples) -> NDArray[np.bool_]:
        """(channels,) whether the last period, as delivered, has flat tops."""
        self._raw = np.concatenate([self._raw, samples], axis=1)[:, -max(self._raw_count, samples.shape[1]) :]
        # Before the burst there is no sine that could be cut; what rests is within the noise.
        return clipped_channels(self._raw, self.noise) & (self._raw.shape[1] >= self._raw_count)

    def add(self, samples: Samples) -> None:
        """Take in what came."""
        if self._skip > 0:
            passed = min(self._skip, samples.shape[1])
            self._skip -= passed
            samples = samples[:, passed:]
        values = np.concatenate([self._rest, samples * self._volts], axis=1)
        whole = values.shape[1] // self._step * self._step
        begin = self._first + self._kept.shape[1]
        self._kept = np.concatenate([self._kept, _averaged(values[:, :whole], self._step)], axis=1)
        self._drive = np.concatenate([self._drive, self._basis(begin, begin + whole // self._step)])
        self._rest = values[:, whole:]

    def next_hop(self) -> bool:
        """Go on to the next look, if all it needs has come."""
        end = self._at((self.hop + 1) * HOP_S)
        if end > self._first + self._kept.shape[1]:
            return False
        self.hop += 1
        needed = self._whole_periods(WEAK_EARLIER_S) + self.gap + self.count(WEAK_LATER_S)
        drop = max(0, end - needed - self._first)
        if drop > needed:
            self._kept, self._drive = self._kept[:, drop:].copy(), self._drive[drop:].copy()
            self._first += drop
        return True

    def ends_of_complete_windows(self) -> NDArray[np.int64]:
        """Where the looks end for which all samples have come, (looks,)."""
        most = int((self._kept.shape[1] * self._dt) / HOP_S) + 2
        ends = [self._at((self.hop + n) * HOP_S) for n in range(1, most)]
        return np.array([end for end in ends if end <= self._first + self._kept.shape[1]], dtype=np.int64)

    def holds_windows(self, ends: NDArray[np.int64], longest: int) -> bool:
        """Whether windows of so many samples, to each of the ends, lie in the burst and are remembered."""
        return bool(ends[0] - longest >= max(self._first, 0) and ends[-1] * self._dt <= self.burst.duration_s)

    def windows(self, ends: NDArray[np.int64], count: int) -> Real:
        """(looks, channels, count) the samples before each of the ends."""
        return np.array([self._cut(end - count, end) for end in ends.tolist()])

    def drive_columns(self, ends: NDArray[np.int64], count: int) -> Real:
        """(looks, count, 3) what the drive lets every channel do there."""
        return np.array([self._drive[end - count - self._first : end - self._first] for end in ends.tolist()])

    def predicted_window(self, later_s: float, earlier_s: float = EARLIER_S) -> tuple[Real, PredictedWindow] | None:
        """The later window of this look, and what the earlier one says of it; None where it is not all of the burst."""
        end, count = self._at(self.hop * HOP_S), self.count(later_s)
        middle = end - count
        begin = middle - self.gap - self._whole_periods(earlier_s)
        stop = middle - self.gap
        windows = (begin, stop), (middle, end)
        if begin < 0 or end * self._dt > self.burst.duration_s:
            return None
        earlier, later = (self._drive[first - self._first : last - self._first] for first, last in windows)
        if not is_driven(earlier):
            return None
        foreseen = predict_later_window(self._cut(begin, stop), earlier, later)
        return self._cut(middle, end), foreseen

    def exchanged_channels(self) -> tuple[int, int] | None:
        """Two channels that are exchanged, by the shapes in which the structure moves; once a look."""
        end = self._at(self.hop * HOP_S)
        middle = end - self.count(self.later_s)
        known = middle - self.gap
        begin = max(known - self.count(HOP_S), self._first, 0)
        if known > begin:
            self.places.add_older_samples(self._cut(begin, known))
        return self.places.find_exchanged(self._cut(middle, end)) if middle >= self._first else None

    def latest_samples(self, seconds: float) -> Real:
        """(channels, n) the samples up to this look, of so long or of all the burst so far."""
        end = self._at(self.hop * HOP_S)
        return self._cut(max(end - self.count(seconds), self._first), end)

    def _at(self, seconds: float) -> int:
        return int((seconds - self._early_s) / self._dt + 1e-9)

    def _whole_periods(self, seconds: float) -> int:
        frequency_hz = self.burst.frequency_hz
        most = max(1, int(MOST_SAMPLES * self._dt * frequency_hz))
        return round(min(ceil(seconds * frequency_hz), most) / (frequency_hz * self._dt))

    def count(self, seconds: float) -> int:
        """Averaged samples of a window."""
        return min(max(8, round(seconds / self._dt)), MOST_SAMPLES)

    def _cut(self, begin: int, end: int) -> Real:
        return self._kept[:, begin - self._first : end - self._first]

    def _basis(self, begin: int, end: int) -> Real:
        """What the drive lets every channel do at some averaged samples, see `tone_basis`."""
        middles = np.arange(begin, end, dtype=np.float64) + (self._step - 1) / (2 * self._step)
        times = middles * self._dt + self._early_s
        return tone_basis(times, self.burst.frequency_hz, self.burst.envelope(times))


def is_driven(basis: Real) -> NDArray[np.bool_]:
    """Whether there is any drive in the (..., n, 3) basis of a window."""
    return np.abs(basis[..., 1:]).max(axis=(-1, -2)) > DRIVEN


def _averaged(values: Real, step: int) -> Real:
    whole = values.shape[1] // step * step
    mean: Real = values[:, :whole].reshape(len(values), -1, step).mean(axis=2).astype(np.float64)
    return mean
