"""The samples of one wave as they come, and what each look at them finds."""

from collections import deque
from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.rest_noise import RepetitionCounter, RestNoise
from modallab.acquisition.monitor.tone_prediction import rms_about_line
from modallab.bench.protocol import SampleChunk, Waveform
from modallab.core.arrays import Real
from modallab.storage.samples import Samples

HOP_S = 0.02
WINDOW_HOPS = 4
"""Between two looks, and what each looks at, in these."""

UNSURE_HOPS = 8
"""So many before the window are neither learned from nor part of the usual level: a fault may lie in them unfound."""

FLAT_S = 0.12
"""What is searched for flat tops."""

LEAST_RATE_HZ = 1000.0
WAVE_OVERSAMPLED = 2.5
"""What is looked at is averaged down to a rate not far above both, so that a look takes the same time at any rate."""

LEAST_LEARNED_S = 0.2
FORGET = 0.02
"""Of what is known, per hop: it is a second old on average."""

USUAL_S = 1.0
"""A channel's own level is its lowest in so long before the window, or in a period of the wave."""

DRIVE_LAGS, LAG_S = 20, 0.001
"""The drive counts by what it was in the last 20 ms: converters delay it by up to 40 periods of their rate."""

DRIVE_SCALE = 100.0
"""The drive's root mean square over the part of it that explains nothing."""

STILL = 2.0
"""Multiple of its noise within which a channel counts as still."""

MOVING = 10.0
"""It was to move by so many times its noise."""

UNEXPLAINED = 4.0
"""And by so many times what the others leave unexplained."""

DRIVEN = 0.3
"""A fall from the usual level is judged while the drive has this part of its root mean square."""

FORCE_STILL, OTHERS_SEEN = 4.0, 100.0
"""Where another channel moves by so many times its noise, and the drive is on, the force must be seen."""

GONE_LOOKS = 3
"""A channel is gone after so many looks in a row."""
_LONG_RUN = 5
STEEP_STEPS, STEEP_NOISE = 20.0, 40.0
"""Beside a flat top of so many samples the signal falls by so many counts, and so many times the noise, within half of
its length: a parabola falls by 5 counts."""

MOST_AT_TOP, OVER_BELOW = 8, 4
"""A signal is also cut off of which so many samples, and so many times those just below it, lie at the top."""

_COARSE = 3
"""So many times as many where the noise is less than a count, and the tops of a sine may well round to one value."""

BELOW_STEPS, BELOW_NOISE = 6.0, 2.0
"""Just below: by so many counts and so many times the noise."""

_MOVES = 5.0
"""A channel is judged from so many times the steep fall on: a smaller one ends at few values by itself."""


class WaveSamples:
    """The samples of one wave: as delivered for flat tops, and averaged, over each channel's noise."""

    def __init__(
        self, waves: Sequence[Waveform], start: int, rest: Samples, noise: RestNoise, rate_hz: float, period_s: float
    ) -> None:
        self._waves, self._start, self._noise, self._rate_hz = tuple(waves), start, noise, rate_hz
        self._channels = len(noise.rms)
        self._repetition = RepetitionCounter(self._channels)
        self._average = max(1, int(rate_hz // max(LEAST_RATE_HZ, waves[0].rate_hz / WAVE_OVERSAMPLED)))
        self._hop = self._average * max(1, round(HOP_S * rate_hz / self._average))
        self._least_learned = LEAST_LEARNED_S * rate_hz / self._average
        self._offset = rest.mean(axis=1, keepdims=True, dtype=np.float64)
        rounding = np.maximum(noise.step, np.finfo(float).tiny) / np.sqrt(12)
        self._white = np.maximum(noise.rms, rounding)[:, None] / np.sqrt(self._average)
        self._level_v = [float(np.sqrt(np.mean(wave.samples**2))) for wave in waves]
        self._raw: Samples = rest[:, :0]
        self._seen_to = start
        self._taken = start
        self._prediction = _ChannelPrediction(self._channels + DRIVE_LAGS * len(waves), FORGET)
        self._hops: deque[Real] = deque(maxlen=WINDOW_HOPS + UNSURE_HOPS)
        self._usual: deque[Real] = deque(maxlen=UNSURE_HOPS + ceil(max(USUAL_S, period_s) / HOP_S))
        self._gone = np.zeros(self._channels, dtype=np.int64)

    def frozen_channels(self, samples: Samples) -> NDArray[np.bool_]:
        """(channels,) whether one value is repeated."""
        return self._repetition.longest_runs(samples) >= self._noise.longest_run

    def add(self, chunk: SampleChunk) -> None:
        """Take in what came; what lies before the wave's start is passed over."""
        late = max(0, self._start - chunk.first_sample)
        self._raw = np.concatenate([self._raw, chunk.samples[:, late:]], axis=1)
        self._seen_to = max(self._start, chunk.first_sample + chunk.samples.shape[1])

    def next_hop(self) -> bool:
        """Go on to the next look, if all it needs has come."""
        if self._taken + self._hop > self._seen_to:
            return False
        self._taken += self._hop
        keep = self._seen_to - self._taken + max(self._hop, round(FLAT_S * self._rate_hz))
        self._raw = self._raw[:, -keep:]
        if len(self._hops) == self._hops.maxlen:
            self._prediction.learn(self._hops[0])
        self._hops.append(self._rows())
        return True

    def cut_off(self) -> NDArray[np.bool_]:
        """(channels,) whether the last samples, as delivered, have flat tops."""
        end = self._raw.shape[1] - (self._seen_to - self._taken)
        return flat_tops(self._raw[:, :end], self._noise)

    def motionless_channels(self, forces: Sequence[int]) -> NDArray[np.bool_]:
        """(channels,) whether a channel has not moved for some looks, where it must; `forces`: by wave."""
        window = np.concatenate(list(self._hops)[-WINDOW_HOPS:], axis=1)
        level = rms_about_line(window[: self._channels])
        # Of each drive as it is now, without a lag.
        drives = window[self._channels :: DRIVE_LAGS]
        driven = np.sqrt(np.mean(drives**2, axis=1)) >= DRIVEN * DRIVE_SCALE
        gone = np.zeros(self._channels, dtype=np.bool_)
        if self._prediction.count >= self._least_learned:
            predicted, unexplained = self._prediction.predict(window, self._channels, 1.0)
            gone |= rms_about_line(predicted) > np.maximum(MOVING, UNEXPLAINED * unexplained)
        if driven.any() and len(self._usual) == self._usual.maxlen:
            gone |= np.min(list(self._usual)[:-UNSURE_HOPS], axis=0) > MOVING
        self._usual.append(level)
        gone &= level < STILL
        for force, on in zip(forces, driven, strict=True):
            gone[force] |= on and level[force] < FORCE_STILL and bool((np.delete(level, force) > OTHERS_SEEN).any())
        self._gone = np.where(gone, self._gone + 1, 0)
        return self._gone >= GONE_LOOKS

    def _rows(self) -> Real:
        """(channels and lags of drives, n) of the last hop: over the noise, and over a part of the drive's level."""
        end = self._raw.shape[1] - (self._seen_to - self._taken)
        raw = (self._raw[:, end - self._hop : end] - self._offset).reshape(self._channels, -1, self._average)
        samples = raw.mean(axis=2) / self._white
        middle = (self._average - 1) / 2
        first = self._taken - self._hop - self._start
        times = (first + middle + self._average * np.arange(samples.shape[1])) / self._rate_hz
        lags = LAG_S * np.arange(DRIVE_LAGS)[:, None]
        drives = [
            DRIVE_SCALE / level_v * wave.at((times - lags).ravel()).reshape(DRIVE_LAGS, -1)
            for wave, level_v in zip(self._waves, self._level_v, strict=True)
        ]
        return np.concatenate([samples, *drives])


class _ChannelPrediction:
    """Learns from stretches, each forgotten little by little, and predicts each channel from the others and the drive.

    A structure moves in a few shapes, so each channel is close to a weighted sum of the others and of the drive of the
    last few milliseconds. With the second moments M of all of them, the weights for channel c are
    -inv(M)[c, j] / inv(M)[c, c], and what they leave unexplained has the variance 1 / inv(M)[c, c] (Lauritzen,
    Graphical Models, 1996, section 5.1).
    """

    def __init__(self, rows: int, forget: float) -> None:
        """For so many rows; `forget` is the part of what is known that each new stretch replaces."""
        self._moments = np.zeros((rows, rows))
        self._count = 0.0
        self._keep = 1 - forget

    @property
    def count(self) -> float:
        """Samples that are known."""
        return self._count

    def learn(self, rows: Real) -> None:
        """Take in (rows, n) samples."""
        self._moments = self._keep * self._moments + rows @ rows.T
        self._count = self._keep * self._count + rows.shape[1]

    def predict(self, rows: Real, channels: int, noise: float) -> tuple[Real, Real]:
        """What (rows, n) samples make the first `channels` read, and the rms that stays unexplained.

        Args:
            rows: channels, then the drive.
            channels: how many of them are predicted.
            noise: rms of each row that explains nothing.
        """
        count = max(self._count, 1.0)
        inverse = np.linalg.inv(self._moments / count + noise**2 * np.eye(len(rows)))
        own = np.diag(inverse)[:channels]
        weights = -inverse[:channels] / own[:, None]
        weights[np.arange(channels), np.arange(channels)] = 0.0
        return weights @ rows, np.sqrt(1 / own)


def flat_tops(window: Samples, noise: RestNoise) -> NDArray[np.bool_]:
    """(channels,) whether the highest, or the lowest, of (channels, n) samples, as delivered, are cut off.

    Near a smooth top a signal is a parabola: half of the samples that lie within four counts of the top lie below the
    first of them, and where several in a row read the same, those further out lie no more than a few counts and a few
    times the noise below. A top that many samples end at, with none just below it or a steep fall beside it, is flat.
    A channel whose noise does not move what it delivers repeats values by itself, and is not judged.
    """
    rows = window.astype(np.float64)
    moves = np.ptp(rows, axis=1) > _MOVES * (STEEP_STEPS * noise.step + STEEP_NOISE * noise.rms)
    found = np.zeros(len(rows), dtype=np.bool_)
    for channel in np.flatnonzero(noise.visible & moves):
        row, rms, step = rows[channel], float(noise.rms[channel]), float(noise.step[channel])
        found[channel] = _is_flat_topped(row, rms, step) or _is_flat_topped(-row, rms, step)
    return found


def _is_flat_topped(row: Real, noise: float, step: float) -> bool:
    top = float(row.max())
    at = np.flatnonzero(row == top)
    if at.size < _LONG_RUN:
        return False
    below = int((row >= top - BELOW_STEPS * step - BELOW_NOISE * noise).sum()) - at.size
    most = MOST_AT_TOP if noise >= step else _COARSE * MOST_AT_TOP
    if at.size >= most and at.size >= OVER_BELOW * below:
        return True
    begins = at[np.diff(at, prepend=-2) > 1]
    ends = at[np.diff(at, append=at[-1] + 2) > 1]
    run = ends - begins + 1
    out = np.maximum(1, run // 2)
    whole = (run >= _LONG_RUN) & (begins >= out) & (ends + out < row.size)
    begins, ends, out = begins[whole], ends[whole], out[whole]
    # The higher of both sides: a jump, as of a dropout, is no top.
    drop = top - np.maximum(row[begins - out], row[ends + out])
    return bool((drop > STEEP_STEPS * step + STEEP_NOISE * noise).any())
