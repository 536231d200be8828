"""Digital filters that lag, and multiplexers that read one channel after the other."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.plant import Source

HALF = 16
"""Samples to either side that the interpolation between samples looks at."""


class DelayedSource:
    """Picks channels out of a source, each with the delay of its module and its turn at the multiplexer."""

    def __init__(
        self,
        begin: Callable[[int], Source],
        rows: Sequence[int],
        delays: Sequence[int],
        turns: Sequence[float],
    ) -> None:
        """Take `rows` of the source, late by whole samples `delays` and read `turns` parts of a sample later.

        Args:
            begin: makes the source, which begins so many samples before the acquisition.
            rows: of the source, in the order of the task.
            delays: (channels,) samples.
            turns: (channels,) parts of a sample.
        """
        self._half = HALF if any(turns) else 0
        longest = max(delays)
        self._source = begin(longest + 2 * self._half)
        self._rows = list(rows)
        self._shifts = [longest - delay for delay in delays]
        self._taps = [_between(turn) if self._half else None for turn in turns]
        keep = max(self._shifts) + 2 * self._half
        volts, overload = self._source.take(keep) if keep else (np.zeros((max(rows) + 1, 0)), None)
        self._volts = volts[self._rows]
        self._overload = np.zeros(self._volts.shape, dtype=np.bool_) if overload is None else overload[self._rows]

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        """The next (channels, count) volts, and (channels,) which went beyond the range."""
        volts, overload = self._source.take(count)
        if not self._volts.shape[1]:
            return volts[self._rows], np.array([row.any() for row in overload[self._rows]])
        volts = np.concatenate([self._volts, volts[self._rows]], axis=1)
        overload = np.concatenate([self._overload, overload[self._rows]], axis=1)
        self._volts, self._overload = volts[:, count:], overload[:, count:]
        picked = [self._pick(volts[c], c, count) for c in range(len(self._rows))]
        flags = [overload[c, s + self._half : s + self._half + count].any() for c, s in enumerate(self._shifts)]
        return np.stack(picked), np.array(flags)

    def changed(self) -> None:
        """The excitation from now on is another than it was."""
        self._source.changed()

    def _pick(self, volts: Floats, channel: int, count: int) -> Floats:
        first, taps = self._shifts[channel], self._taps[channel]
        if taps is None:
            return volts[first + self._half : first + self._half + count]
        return np.convolve(volts[first : first + count + 2 * self._half], taps[::-1], mode="valid")


def _between(turn: float) -> Floats:
    offsets = np.arange(-HALF, HALF + 1) - turn
    taps = np.sinc(offsets) * np.kaiser(2 * HALF + 1, 8.0)
    return taps / taps.sum()
