"""What every channel does at rest: its own noise, and how long it may repeat the same value."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.storage.samples import Samples

RARE = 1e-15
"""Probability, for noise that goes from sample to sample by itself, of a repetition that counts as frozen."""

LEAST_RUN = 8
"""Samples; a converter that holds each value for some samples of its rate repeats it as often at rest, too."""

RESTING_RUN = 3
"""A repetition is frozen from so many times the longest at rest on."""

FLAT_PART = 0.15
FLAT_NOISE = 20.0
"""A channel that moves over so many times its noise is cut off where this part of its samples is its highest, or its
lowest: a sine cut at less than 0.9 of its height has more."""

LEAST_COUNTS = 0.5
"""A noise of fewer counts may hide in one count, and says nothing by doing so."""

FALLEN = 0.3
"""A noise fallen to this part of what it was is none of the sensor's."""


@dataclass(frozen=True, eq=False, slots=True)
class RestNoise:
    """The noise of all channels at rest.

    Attributes:
        rms: (channels,) as delivered, of what goes from sample to sample: a slow motion that rings on is not in it.
        longest_run: (channels,) equal samples in a row from which on a channel is frozen; infinite where that says
            nothing.
        visible: (channels,) whether the noise moves what is delivered.
        step: (channels,) the converter's count, as delivered; 0 where none was seen.
    """

    rms: Real
    longest_run: Real
    visible: NDArray[np.bool_]
    step: Real

    @classmethod
    def of(cls, window: Samples, *, counts: bool) -> Self:
        """Of a (channels, n) window at rest, as delivered; `counts`: in whole numbers."""
        rms = _fast_rms(window)
        steps = np.abs(np.diff(window.astype(float), axis=1))
        same = steps == 0
        # Real numbers have a count as well, that of the converter they came from: their smallest step.
        step = np.ones(len(rms)) if counts else np.min(np.where(same, np.inf, steps), axis=1)
        visible = rms >= LEAST_COUNTS * step
        often = np.maximum(same.mean(axis=1), _usual_repeats(rms / step))
        likely = np.log(RARE) / np.log(np.minimum(often, 1 - 1e-9))
        resting = RESTING_RUN * np.array([_longest_run(row) for row in same])
        longest = np.where(visible, np.maximum(np.maximum(likely, LEAST_RUN), resting), np.inf)
        return cls(rms, longest, visible, np.where(np.isfinite(step), step, 0.0))

    def below_earlier_noise(self, later: "RestNoise") -> NDArray[np.bool_]:
        """(channels,) whether the noise has fallen below the channel's own since."""
        return self.visible & (later.rms < FALLEN * self.rms)

    def ends_frozen(self, window: Samples) -> NDArray[np.bool_]:
        """(channels,) whether a (channels, n) window ends in a value repeated for longer than the noise could."""
        changed = window[:, ::-1] != window[:, -1:]
        run = np.where(changed.any(axis=1), changed.argmax(axis=1), window.shape[1])
        return run >= self.longest_run

    def with_shorter_runs_of(self, other: "RestNoise") -> "RestNoise":
        """The same, frozen from what is so for another rest as well: a rest that was half frozen says nothing."""
        return replace(self, longest_run=np.minimum(self.longest_run, other.longest_run))


def clipped_channels(window: Samples, noise: RestNoise) -> NDArray[np.bool_]:
    """(channels,) whether the tops of a (channels, n) window are all of one value: clipped."""
    highest, lowest = window.max(axis=1, keepdims=True), window.min(axis=1, keepdims=True)
    flat = np.maximum((window == highest).mean(axis=1), (window == lowest).mean(axis=1))
    moves = highest[:, 0].astype(float) - lowest[:, 0].astype(float) > FLAT_NOISE * noise.rms
    return noise.visible & moves & (flat > FLAT_PART)


class RepetitionCounter:
    """Counts, over chunks, how often each channel has repeated its last value."""

    def __init__(self, channels: int) -> None:
        self._last: NDArray[np.generic] | None = None
        self._run = np.zeros(channels, dtype=np.int64)

    def longest_runs(self, samples: Samples) -> NDArray[np.int64]:
        """(channels,) the longest run of equal samples that ends in the next (channels, n) samples."""
        last = self._last if self._last is not None else samples[:, 0]
        self._last = samples[:, -1].copy()
        changed = np.concatenate([(samples[:, 0] != last)[:, None], np.diff(samples, axis=1) != 0], axis=1)
        found = np.zeros(len(samples), dtype=np.int64)
        for channel, row in enumerate(changed):
            at = np.flatnonzero(row)
            if at.size == 0:
                self._run[channel] += row.size
                found[channel] = self._run[channel]
                continue
            within = int(np.diff(np.append(at, row.size)).max())
            found[channel] = max(int(self._run[channel] + at[0]), within)
            self._run[channel] = row.size - at[-1]
        return found


def _usual_repeats(rms: Real) -> Real:
    """(channels,) how often noise of an rms in counts, rounding included, repeats its count where that is likeliest."""
    sigma = np.sqrt(np.maximum(rms**2 - 1 / 12, 0.01))
    # In the middle of a count; the counts next to it add what they share.
    near = np.exp(-0.5 * (np.arange(-3, 4)[:, None] / sigma) ** 2)
    share = near / near.sum(axis=0)
    return (share**2).sum(axis=0)


def _fast_rms(window: Samples) -> Real:
    # The second difference of white noise has sqrt(6) times its rms; of a slow motion nearly nothing.
    return np.diff(window.astype(float), n=2, axis=1).std(axis=1) / np.sqrt(6)


def _longest_run(same: NDArray[np.bool_]) -> int:
    edges = np.flatnonzero(~np.concatenate([[False], same, [False]]))
    return int(np.diff(edges).max(initial=1))
