"""What stands behind inputs and outputs, sampled by each card's own clock: the cantilever, or cables between them."""

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, inf
from typing import Any, Protocol, Self, cast

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import AcquisitionRequest
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Converter, Rig
from modallab.core.units import Test
from modallab_simulators.cantilever.address import parse_address
from modallab_simulators.cantilever.bench import CantileverBench
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.lines import Floats, OutputLine
from modallab_simulators.ni_daqmx_server.status import StatusError

LATENCY_S = 0.002
STEP_V = 1e-9


class Source(Protocol):
    """Samples of one acquisition, in V, from all sensors of the rig."""

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        """The next (channels, count) volts, and which of them are beyond the range."""
        ...

    def changed(self) -> None:
        """The excitation has changed: what was computed ahead does not hold."""
        ...


class Plant(Protocol):
    """What the inputs are connected to."""

    generator_ppm: float
    facts: dict[str, str]

    def begin(self, rate_hz: float, start_s: float, lines: Sequence[OutputLine]) -> Source:
        """Samples from `start_s` on, while the outputs drive, one `line` for each shaker."""
        ...

    def strike(self, point: int, now_s: float) -> None:
        """The operator will strike a point."""
        ...

    def set_preamplifiers(self, test: Test) -> None:
        """The operator turns the preamplifiers' knobs."""
        ...


@dataclass(frozen=True, eq=False, slots=True)
class _LineEmission:
    """Whatever stands on the output line, as the simulated shaker takes it."""

    line: OutputLine
    began_s: float
    start_s: float = 0.0
    end_s: float = inf
    cut_s: float | None = None

    def cut(self, at_s: float) -> Self:
        """The line is brought to zero by whoever drives it."""
        return self

    def volts(self, times_s: Floats) -> Floats:
        """In V at times since the stream began."""
        return np.where(times_s < 0, 0.0, self.line.volts(times_s + self.began_s))


class CantileverPlant:
    """The simulated cantilever with its sensors and preamplifiers."""

    def __init__(self, url: str, rig: Rig, range_v: float, bits: int) -> None:
        channels = tuple(channel.model_copy(update={"range_v": range_v}) for channel in rig.channels)
        noise = (rig.converter or Converter()).noise_rms_v
        converter = Converter(bits=bits, range_v=range_v, noise_rms_v=noise)
        self._bench = CantileverBench(
            url, rig.model_copy(update={"channels": channels, "converter": converter}), parse_address(url)
        )
        self._bits = bits
        self._test: Test = "impact"
        self.facts = self._bench.info.facts
        self.generator_ppm = float(self.facts.get("generator_ppm", 0.0))

    def begin(self, rate_hz: float, start_s: float, lines: Sequence[OutputLine]) -> Source:
        """See `Plant`.

        Raises:
            StatusError: the bench cannot be sampled at such a rate.
        """
        self._bench.stop()
        try:
            delivery = self._bench.configure(AcquisitionRequest(self._test, rate_hz))
        except ConfigurationError as error:
            said = f"Property: SampClk.Rate\nRequested Value: {rate_hz:g}\n{error}"
            raise StatusError(status.INVALID_VALUE, said) from error
        self._bench.start()
        # The bench plays bursts; a device plays whatever was written to it, so it is put beneath.
        inner = cast("Any", self._bench)
        inner._excitation.play_outputs(*(_LineEmission(line, start_s) for line in lines))
        return _CantileverSource(self._bench, delivery.scale, 2 ** (self._bits - 1))

    def strike(self, point: int, now_s: float) -> None:
        """See `Plant`."""
        self._bench.prompt_hit(point)

    def set_preamplifiers(self, test: Test) -> None:
        """See `Plant`; heard from the next start on."""
        self._test = test


class _CantileverSource:
    def __init__(self, bench: CantileverBench, volts_per_count: Floats, full: int) -> None:
        self._bench, self._volts_per_count, self._full = bench, volts_per_count, full

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        counts: NDArray[Any] = self._bench.read(count, inf).samples
        overload = (counts >= self._full - 1) | (counts <= -self._full)
        return counts * self._volts_per_count[:, None], overload

    def changed(self) -> None:
        cast("Any", self._bench)._stream.excitation_changed()


class CablePlant:
    """Every input hangs on an output by a cable; a slow ramp of STEP_V a sample lets every sample be distinguished.

    With several shakers the first inputs hang on one output each, the rest on the last of them.
    """

    def __init__(self, channels: int, range_v: float) -> None:
        self._channels, self._range_v = channels, range_v
        self.facts: dict[str, str] = {}
        self.generator_ppm = 0.0

    def begin(self, rate_hz: float, start_s: float, lines: Sequence[OutputLine]) -> Source:
        """See `Plant`."""
        return _CableSource(self._channels, self._range_v, rate_hz, start_s, lines)

    def strike(self, point: int, now_s: float) -> None:
        """There is no beam to strike."""

    def set_preamplifiers(self, test: Test) -> None:
        """There are none."""


class _CableSource:
    def __init__(
        self, channels: int, range_v: float, rate_hz: float, start_s: float, lines: Sequence[OutputLine]
    ) -> None:
        self._channels, self._range_v = channels, range_v
        self._rate_hz, self._start_s, self._lines = rate_hz, start_s, tuple(lines)
        self._position = 0

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        places = self._position + np.arange(count)
        self._position += count
        times = self._start_s + places / self._rate_hz
        volts = [np.clip(line.volts(times) + STEP_V * places, -self._range_v, self._range_v) for line in self._lines]
        every = np.stack([volts[min(row, len(volts) - 1)] for row in range(self._channels)])
        return every, np.abs(every) >= self._range_v

    def changed(self) -> None:
        """Nothing is computed ahead."""


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
