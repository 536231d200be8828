"""What stands behind the simulated inputs and outputs: the cantilever, or cables from the output to every input."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol, Self, cast

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Request
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Converter, Rig
from modallab.core.units import Test
from modallab_simulators.cantilever.address import parse
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
            url, rig.model_copy(update={"channels": channels, "converter": converter}), parse(url)
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
            delivery = self._bench.configure(Request(self._test, rate_hz))
        except ConfigurationError as error:
            said = f"Property: SampClk.Rate\nRequested Value: {rate_hz:g}\n{error}"
            raise StatusError(status.INVALID_VALUE, said) from error
        self._bench.start()
        # The bench plays bursts; a device plays whatever was written to it, so it is put beneath.
        inner = cast("Any", self._bench)
        inner._excitation.emit(*(_LineEmission(line, start_s) for line in lines))
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
        cast("Any", self._bench)._stream.changed()


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
