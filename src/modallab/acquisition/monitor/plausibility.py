"""While a burst is on: whether the force, and every channel with a limit, still says what the drive must make it say.

A dead channel looks safe to a limit, and like too little force to a force control. So a burst goes on only as long as
each of these channels follows the drive as it did a moment ago (`tone_prediction`), does not repeat one value, and the
force is there at all and within what the last burst gave for this drive. A channel whose motion lies under its noise
cannot be held against anything; it is judged by repetition alone until it moves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.rest_noise import Repetition, RestNoise, cut_off
from modallab.acquisition.monitor.tone_prediction import (
    Foreseen,
    astray,
    dead,
    faults,
    foresee,
    kept_up,
    lost,
    tone_basis,
)
from modallab.bench.protocol import Burst, Chunk
from modallab.core.errors import SafetyError
from modallab.storage.samples import Samples

Real = NDArray[np.float64]

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

GONE_LOOKS = 3
"""A tone is gone after so many looks in a row."""

LEAST_RATE_HZ = 1000.0
SAMPLES_PER_PERIOD = 32
"""What is looked at is averaged down to a rate not far above both, so that a look takes the same time at any rate."""

MOST_SAMPLES = 2000
"""Longest window, in averaged samples; above 600 Hz the windows get shorter for it."""

KEPT_UP = 0.5
"""Where the other responses fall to this part of what was foreseen, the structure itself may beat."""

SEEN = 4.0
"""A tone so many times above what noise makes of it is seen."""

OTHERS_SEEN = 100.0
OTHERS_FROM = 0.1
"""Where another channel is seen so clearly, from this part of the drive on, the force must be seen."""

MISSED = 100 * SEEN
"""A response that was to be seen so clearly, by the last burst and by the other responses, stands in no node."""

FORCE_BRACKET = 30.0
"""The force per volt may change so much from one frequency to another; at a resonance it drops."""

SAME_FREQUENCY = 0.002
SAME_BRACKET = 2.0
"""And so much between two settled bursts at one frequency."""

REMEDY = "check the channel's sensor, cable and input; the blocks before are kept, the one under way is not"


@dataclass(frozen=True, slots=True)
class LastBurst:
    """What a settled burst gave: force in N per volt of the drive."""

    frequency_hz: float
    force_n_per_v: float


class Plausibility:
    """Holds each channel of a burst against the drive; at rest it sees nothing."""

    def __init__(
        self, names: Sequence[str], si_per_count: Real, volts: Real, force: int, watched: Sequence[int], rate_hz: float
    ) -> None:
        """Watch channels.

        Args:
            names: of all channels.
            si_per_count: (channels,) SI units per delivered number.
            volts: (channels,) V, or whatever all share, per delivered number: a plug that is swapped swaps these.
            force: the force's channel.
            watched: channels of force and of limits.
            rate_hz: of the device.
        """
        self._names, self._si, self._volts, self._force = tuple(names), np.abs(si_per_count), np.abs(volts), force
        self._watched = np.isin(np.arange(len(names)), watched)
        self._rate_hz = rate_hz
        self._burst: _BurstLook | None = None
        self.last: LastBurst | None = None
        self._last_tone: Real | None = None

    def begin(self, burst: Burst, start: int, rest: Samples, noise: RestNoise, unseen: int) -> None:
        """A burst begins.

        Args:
            burst: as it was asked for.
            start: sample its rise begins with.
            rest: (channels, n) delivered numbers just before it.
            noise: of the same.
            unseen: the next sample that a chunk will bring.
        """
        self._burst = _BurstLook(burst, start, self._rate_hz, rest, self._volts, noise, unseen)

    def end(self) -> None:
        """The burst has ended."""
        self._burst = None

    def settled(self, frequency_hz: float, force_n: float, volts: float) -> None:
        """Hold the force of a settled block against the last burst, and remember it.

        Raises:
            SafetyError: it is no force, or not what this drive gave before at this frequency.
        """
        if not np.isfinite(force_n) or force_n <= 0:
            raise _error(f"{self._names[self._force]} reads {force_n:g} N at {volts:g} V of drive")
        found, last = force_n / volts, self.last
        if last is not None and abs(frequency_hz / last.frequency_hz - 1) <= SAME_FREQUENCY:
            change = found / last.force_n_per_v
            if not 1 / SAME_BRACKET <= change <= SAME_BRACKET:
                raise _error(
                    f"{self._names[self._force]} reads {found:.4g} N per V of drive at {frequency_hz:g} Hz, where the"
                    f" burst before gave {last.force_n_per_v:.4g} N per V"
                )
        self.last = LastBurst(frequency_hz, found)
        self._last_tone = self._burst.tone if self._burst is not None else None

    def __call__(self, chunk: Chunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: names the channel and what has become of it.
        """
        look = self._burst
        if look is None:
            return
        run = look.repetition.longest(chunk.samples)
        frozen = np.flatnonzero(self._watched & (run >= look.noise.longest_run))
        if frozen.size:
            first = int(frozen[0])
            raise _error(f"{self._names[first]} repeats one value for {run[first]} samples: frozen")
        cut = np.flatnonzero(self._watched & look.cut_off(chunk.samples))
        if cut.size:
            raise _error(f"{self._names[int(cut[0])]} is cut off: all its highest samples read the same")
        look.add(chunk.samples)
        while look.next_hop():
            self._require_all(look)

    def _require_all(self, look: "_BurstLook") -> None:
        pair = look.foreseen(look.later_s)
        if pair is None:
            return
        for channel, reason in faults(*pair, look.noise_v, look.white_v).items():
            if self._watched[channel]:
                raise _error(f"{self._names[channel]} {reason.format(*self._names)}")
        gone = self._unless_beats(dead(*pair, look.white_v), *pair)
        # The responses may beat; the force follows the drive directly.
        gone[self._force] |= astray(*pair, look.noise_v)[self._force]
        weak = look.foreseen(WEAK_LATER_S, WEAK_EARLIER_S)
        if weak is not None:
            gone |= self._unless_beats(lost(*weak, look.white_v), *weak)
        gone |= self._missing(look, pair[1])
        look.gone = np.where(gone, look.gone + 1, 0)
        for channel in np.flatnonzero((look.gone >= GONE_LOOKS) & self._watched):
            raise _error(f"{self._names[channel]} no longer follows the drive: dead, frozen or unplugged")
        self._require_force(look, pair[1])

    def _missing(self, look: "_BurstLook", foreseen: Foreseen) -> NDArray[np.bool_]:
        """(channels,) whether a response seen well in the last burst shows nothing, though the others answer."""
        tone = look.tone = np.sqrt(2) * foreseen.level / look.sigma_v
        if self._last_tone is None or look.envelope_earlier < OTHERS_FROM:
            return np.zeros(len(tone), dtype=np.bool_)
        answer = np.median(np.delete(tone / np.maximum(self._last_tone, SEEN), self._force))
        missing = (tone <= SEEN) & (answer * self._last_tone > MISSED)
        missing[self._force] = False
        return missing

    def _unless_beats(self, gone: NDArray[np.bool_], seen: Real, foreseen: Foreseen) -> NDArray[np.bool_]:
        """(channels,) without those whose fall may be the structure's own beat: the other responses fall too."""
        follows = kept_up(seen, foreseen) if gone.any() else np.zeros(0)
        for channel in np.flatnonzero(gone):
            others = np.delete(follows, np.array([self._force, int(channel)]))
            gone[channel] = channel == self._force or not others.size or np.median(others) >= KEPT_UP
        return gone

    def _require_force(self, look: "_BurstLook", foreseen: Foreseen) -> None:
        """The force must be seen once another channel is, or the burst is at full level; and within the bracket."""
        least = SEEN * look.sigma_v
        tone = np.sqrt(2) * foreseen.level
        drive = look.envelope_earlier
        force = self._force
        per_v = self._si[force] / self._volts[force] / look.burst.amplitude_v
        if tone[force] <= least[force]:
            others = np.delete(tone > OTHERS_SEEN * look.sigma_v, force)
            expected = self.last.force_n_per_v / FORCE_BRACKET / per_v * drive if self.last else 0.0
            if (others.any() and drive > OTHERS_FROM) or look.steady or expected > least[force]:
                raise _error(f"{self._names[force]} shows no force at {look.burst.amplitude_v * drive:.3g} V of drive")
        elif self.last is not None and foreseen.misfit[force] < 0.1 * foreseen.level[force]:
            change = foreseen.amplitude[force] * per_v / self.last.force_n_per_v
            if not 1 / FORCE_BRACKET <= change <= FORCE_BRACKET:
                raise _error(
                    f"{self._names[force]} reads {change:.3g} times the force per volt of the burst before, at"
                    f" {self.last.frequency_hz:g} Hz"
                )


class _BurstLook:
    """The samples of one burst as they come, averaged down, with the two windows of each look."""

    def __init__(
        self, burst: Burst, start: int, rate_hz: float, rest: Samples, volts: Real, noise: RestNoise, unseen: int
    ) -> None:
        self.burst, self.noise = burst, noise
        self.repetition = Repetition(len(volts))
        self.tone: Real | None = None
        self.gone = np.zeros(len(volts), dtype=np.int64)
        self._step = max(1, int(rate_hz // max(SAMPLES_PER_PERIOD * burst.frequency_hz, LEAST_RATE_HZ)))
        self._dt = self._step / rate_hz
        self._volts = volts[:, None]
        # Times count from the burst's start; samples before it, which are still to come, are passed over.
        self._skip = start - unseen
        self._early_s = max(-self._skip, 0) / rate_hz
        self._rest = np.zeros((len(volts), 0))
        self._kept = np.zeros((len(volts), 0))
        self._first = 0
        self._raw: Samples = rest[:, :0]
        self._raw_count = ceil(max(EARLIER_S, 1 / burst.frequency_hz) * rate_hz)
        self._hop = 0
        self._earlier = self._whole_periods(EARLIER_S)
        self._gap = round(GAP_S / self._dt)
        self.later_s = min(max(LATER_S, LATER_PERIODS / burst.frequency_hz), WEAK_LATER_S)
        averaged = _averaged(rest * self._volts, self._step)
        rounding = np.maximum(noise.step * volts, np.finfo(float).tiny) / np.sqrt(12 * self._step)
        self.noise_v = np.maximum(averaged.std(axis=1), rounding)
        # What has not rung down, or hums, must not pass for a noise that a lost tone falls back to.
        self.white_v = np.minimum(self.noise_v, np.maximum(noise.rms * volts / np.sqrt(self._step), rounding))
        self.sigma_v = self.noise_v * np.sqrt(2 / self._earlier)

    @property
    def envelope_earlier(self) -> float:
        """Of the drive in the middle of the earlier window, 0 to 1."""
        middle = self._hop * HOP_S - self.later_s - (self._gap + self._earlier / 2) * self._dt
        return float(self.burst.envelope(np.array([middle]))[0])

    @property
    def steady(self) -> bool:
        """Whether both windows lie past the rise and before the fall."""
        begins = (self._hop * HOP_S) - (self._earlier + self._gap) * self._dt - self.later_s
        return begins >= self.burst.ramp_s and self._hop * HOP_S <= self.burst.duration_s - self.burst.ramp_s

    def cut_off(self, samples: Samples) -> NDArray[np.bool_]:
        """(channels,) whether the last period, as delivered, has flat tops."""
        self._raw = np.concatenate([self._raw, samples], axis=1)[:, -max(self._raw_count, samples.shape[1]) :]
        # Before the burst there is no sine that could be cut; what rests is within the noise.
        return cut_off(self._raw, self.noise) & (self._raw.shape[1] >= self._raw_count)

    def add(self, samples: Samples) -> None:
        """Take in what came."""
        if self._skip > 0:
            passed = min(self._skip, samples.shape[1])
            self._skip -= passed
            samples = samples[:, passed:]
        values = np.concatenate([self._rest, samples * self._volts], axis=1)
        whole = values.shape[1] // self._step * self._step
        self._kept = np.concatenate([self._kept, _averaged(values[:, :whole], self._step)], axis=1)
        self._rest = values[:, whole:]

    def next_hop(self) -> bool:
        """Go on to the next look, if all it needs has come."""
        end = self._at((self._hop + 1) * HOP_S)
        if end > self._first + self._kept.shape[1]:
            return False
        self._hop += 1
        needed = self._whole_periods(WEAK_EARLIER_S) + self._gap + self._count(WEAK_LATER_S)
        drop = max(0, end - needed - self._first)
        if drop > needed:
            self._kept = self._kept[:, drop:].copy()
            self._first += drop
        return True

    def foreseen(self, later_s: float, earlier_s: float = EARLIER_S) -> tuple[Real, Foreseen] | None:
        """The later window of this look, and what the earlier one says of it; None where it is not all of the burst."""
        end, count = self._at(self._hop * HOP_S), self._count(later_s)
        middle = end - count
        begin = middle - self._gap - self._whole_periods(earlier_s)
        stop = middle - self._gap
        if begin < 0 or end * self._dt > self.burst.duration_s:
            return None
        if self.burst.envelope(self._times(begin, stop)).max() < 1e-6:
            return None
        foreseen = foresee(self._cut(begin, stop), self._basis(begin, stop), self._basis(middle, end))
        return self._cut(middle, end), foreseen

    def _at(self, seconds: float) -> int:
        return int((seconds - self._early_s) / self._dt + 1e-9)

    def _whole_periods(self, seconds: float) -> int:
        frequency_hz = self.burst.frequency_hz
        most = max(1, int(MOST_SAMPLES * self._dt * frequency_hz))
        return round(min(ceil(seconds * frequency_hz), most) / (frequency_hz * self._dt))

    def _count(self, seconds: float) -> int:
        return min(max(8, round(seconds / self._dt)), MOST_SAMPLES)

    def _cut(self, begin: int, end: int) -> Real:
        return self._kept[:, begin - self._first : end - self._first]

    def _times(self, begin: int, end: int) -> Real:
        return (
            np.arange(begin, end, dtype=np.float64) + (self._step - 1) / (2 * self._step)
        ) * self._dt + self._early_s

    def _basis(self, begin: int, end: int) -> Real:
        times = self._times(begin, end)
        return tone_basis(times, self.burst.frequency_hz, self.burst.envelope(times))


def _averaged(values: Real, step: int) -> Real:
    whole = values.shape[1] // step * step
    mean: Real = values[:, :whole].reshape(len(values), -1, step).mean(axis=2).astype(np.float64)
    return mean


def _error(what: str) -> SafetyError:
    return SafetyError(f"{what}; the output was brought to 0 V", remedy=REMEDY)
