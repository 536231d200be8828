"""A device: its channels, rates, ranges and delays, and the rate it gives for a requested one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import floor, isfinite
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.plant import Source
from modallab_simulators.ni_daqmx_server.status import INVALID_VALUE, StatusError

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


Clock = Literal["divided", "timebase", "fine"]

_OVERSAMPLING = 256
_MOST_DIVIDED = 31


@dataclass(frozen=True, slots=True)
class Module:
    """One device.

    Attributes:
        name: as the system names it.
        product: product type.
        serial: serial number.
        inputs: analog inputs.
        outputs: analog outputs.
        input_range_v: the widest of the inputs.
        output_range_v: of the outputs.
        bits: of the input converter.
        clock: `divided`: the timebase / 256 / n, n to 31; `timebase`: it / n; `fine`: as asked for.
        timebase_hz: what the sample clock is divided from.
        max_rate_hz: per channel, or of all channels together where they share a converter.
        min_rate_hz: where the clock itself sets none.
        delay_samples: of the converter's digital filter.
        multiplexed: whether channels share one converter.
        bridge: whether inputs feed bridges.
        ports: digital lines of each port.
        counters: counters that measure and generate pulses.
        narrower_v: further ranges of the inputs.
        currents_a: of the excitation of IEPE sensors, as the device lists them; empty: it has none.
        max_output_hz: of the outputs.
        delta_sigma: whether converters oversample, so that only a sync pulse aligns two devices.
        measures: what the inputs can be asked to measure beyond voltage and IEPE, by the names of the channel calls.
        bridge_ranges: of bridges, V/V.
        category, bus: as the device names its family and what it is plugged into.
        product_number: as the device gives it.
        chassis: name of the chassis it is in, and the slot.
        simulated: whether it is one of those that the driver itself makes up.
        ppm: what its own clock is off by.
    """

    name: str
    product: str
    serial: int
    inputs: int = 0
    outputs: int = 0
    input_range_v: float = 10.0
    output_range_v: float = 10.0
    bits: int = 16
    clock: Clock = "timebase"
    timebase_hz: float = 80e6
    max_rate_hz: float = 100_000.0
    min_rate_hz: float = 0.0
    delay_samples: int = 0
    multiplexed: bool = False
    bridge: bool = False
    ports: tuple[int, ...] = ()
    counters: int = 0
    narrower_v: tuple[float, ...] = ()
    currents_a: tuple[float, ...] = ()
    max_output_hz: float = 100_000.0
    delta_sigma: bool = False
    measures: tuple[str, ...] = ()
    bridge_ranges: tuple[float, ...] = ()
    category: int = 14658
    bus: int = 14741
    product_number: int = 0
    chassis: str = ""
    slot: int = 0
    simulated: bool = False
    ppm: float = 0.0

    @property
    def iepe(self) -> bool:
        """Whether inputs feed IEPE sensors."""
        return bool(self.currents_a)

    def ranges_v(self) -> tuple[float, ...]:
        """All ranges of the inputs, the narrowest first."""
        return tuple(sorted({*self.narrower_v, self.input_range_v}))

    def port_names(self) -> tuple[str, ...]:
        """Digital ports."""
        return tuple(f"{self.name}/port{n}" for n in range(len(self.ports)))

    def counter_names(self) -> tuple[str, ...]:
        """Counters."""
        return tuple(f"{self.name}/ctr{n}" for n in range(self.counters))

    def input_names(self) -> tuple[str, ...]:
        """Physical channels of the inputs."""
        return tuple(f"{self.name}/ai{n}" for n in range(self.inputs))

    def output_names(self) -> tuple[str, ...]:
        """Physical channels of the outputs."""
        return tuple(f"{self.name}/ao{n}" for n in range(self.outputs))

    def line_names(self) -> tuple[str, ...]:
        """Digital lines."""
        return tuple(f"{self.name}/port{p}/line{n}" for p, lines in enumerate(self.ports) for n in range(lines))

    def convert_rate_hz(self, channels: int, rate_hz: float) -> float:
        """Rate at which a multiplexer steps through its channels: the fastest plus 10 us, if there is time for it."""
        relaxed = 1 / (1 / self.max_rate_hz + 10e-6)
        return relaxed if relaxed >= channels * rate_hz else channels * rate_hz


def coerced_rate(modules: tuple[Module, ...], channels: int, rate_hz: float) -> float:
    """The rate the devices give for a requested one: never a lower one, except past their highest.

    Raises:
        StatusError: no rate, or one above what the devices can do.
    """
    if not isfinite(rate_hz) or rate_hz <= 0:
        raise StatusError(INVALID_VALUE, f"Property: SampClk.Rate\nRequested Value: {rate_hz}")
    share = max(channels if m.multiplexed else 1 for m in modules)
    highest = min(m.max_rate_hz for m in modules) / share
    if rate_hz > highest * (1 + 1e-9):
        raise StatusError(
            INVALID_VALUE, f"Property: SampClk.Rate\nRequested Value: {rate_hz}\nMaximum Value: {highest}"
        )
    divided = [m for m in modules if m.clock == "divided"]
    if divided:
        # Modules in one task share one timebase, and its grid.
        grid_hz = divided[0].timebase_hz / _OVERSAMPLING
        return grid_hz / min(_MOST_DIVIDED, max(1, floor(grid_hz / rate_hz * (1 + 1e-12))))
    if any(m.clock == "fine" for m in modules):
        return max(rate_hz, *(m.min_rate_hz for m in modules))
    timebase_hz = modules[0].timebase_hz
    return timebase_hz / max(1, floor(timebase_hz / rate_hz * (1 + 1e-12)))
