"""One plant behind several clocks: each card samples the same motion at its own times."""

import weakref
from collections.abc import Sequence
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from modallab.core.units import Test
from modallab_simulators.ni_daqmx_server.lines import Floats, OutputLine
from modallab_simulators.ni_daqmx_server.plant import Plant, Source

HALF = 24
"""Samples to either side that the interpolation looks at."""
MARGIN = 4 * HALF + 256
KEPT = 1 << 17
EXACT = 1e-7


class SharedPlant:
    """A plant that several acquisitions look at at once, each with its own rate and start."""

    def __init__(self, inner: Plant) -> None:
        self._inner = inner
        self.generator_ppm, self.facts = inner.generator_ppm, inner.facts
        self._stream: _Stream | None = None

    def begin(self, rate_hz: float, start_s: float, lines: Sequence[OutputLine]) -> Source:
        """See `Plant`."""
        if self._stream is None or not self._stream.readers or start_s < self._stream.earliest_s + HALF / rate_hz:
            began_s = start_s - MARGIN / rate_hz
            self._stream = _Stream(self._inner.begin(rate_hz, began_s, lines), rate_hz, began_s)
        return _Reader(self._stream, rate_hz, start_s)

    def strike(self, point: int, now_s: float) -> None:
        """See `Plant`."""
        self._inner.strike(point, now_s)

    def set_preamplifiers(self, test: Test) -> None:
        """See `Plant`."""
        self._inner.set_preamplifiers(test)


class _Stream:
    def __init__(self, source: Source, rate_hz: float, began_s: float) -> None:
        self.source, self.rate_hz, self.began_s = source, rate_hz, began_s
        self.readers: weakref.WeakSet[_Reader] = weakref.WeakSet()
        volts, overload = source.take(1)
        self._volts, self._overload, self._first = volts, overload, 0

    @property
    def earliest_s(self) -> float:
        """Time of the first sample that is kept."""
        return self.began_s + self._first / self.rate_hz

    def between(self, first: int, end: int) -> tuple[Floats, NDArray[np.bool_]]:
        """Samples of the stream by their places."""
        missing = end - self._first - self._volts.shape[1]
        if missing > 0:
            volts, overload = self.source.take(missing)
            self._volts = np.concatenate([self._volts, volts], axis=1)
            self._overload = np.concatenate([self._overload, overload], axis=1)
        place = slice(first - self._first, end - self._first)
        found = self._volts[:, place], self._overload[:, place]
        spare = self._volts.shape[1] - KEPT
        if spare > KEPT:
            self._volts, self._overload = self._volts[:, spare:], self._overload[:, spare:]
            self._first += spare
        return found


class _Reader:
    def __init__(self, stream: _Stream, rate_hz: float, start_s: float) -> None:
        self._stream, self._rate_hz, self._start_s, self._position = stream, rate_hz, start_s, 0
        stream.readers.add(self)

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        """See `Source`."""
        times = self._start_s + (self._position + np.arange(count)) / self._rate_hz
        self._position += count
        places = (times - self._stream.began_s) * self._stream.rate_hz
        first, end = floor(places[0]) - HALF, ceil(places[-1]) + HALF + 1
        volts, overload = self._stream.between(first, end)
        nearest = np.round(places).astype(np.int64)
        if np.abs(places - nearest).max() < EXACT:
            picked = nearest - first
            return volts[:, picked], overload[:, picked]
        return resampled(volts, places - first), overload[:, nearest - first]

    def changed(self) -> None:
        """See `Source`."""
        self._stream.source.changed()


def resampled(volts: Floats, places: Floats) -> Floats:
    """(channels, n) values between samples, at `places` in samples, by a windowed sinc of 2 HALF + 1 samples."""
    whole = np.floor(places).astype(np.int64)
    part = places - whole
    result = np.zeros((volts.shape[0], len(places)))
    total = np.zeros(len(places))
    for step in range(1 - HALF, HALF + 1):
        away = (step - part) / HALF
        weight = np.sinc(step - part) * _window(away)
        total += weight
        result += volts[:, whole + step] * weight
    return result / total


def _window(away: Floats) -> Floats:
    return np.i0(10.0 * np.sqrt(np.clip(1 - away**2, 0.0, 1.0))) / np.i0(10.0)
