"""What a task's channels see: the bench, an output by an internal loop, or the sine that the driver makes up."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.input_task import InputChannel
from modallab_simulators.ni_daqmx_server.lines import Floats, OutputLine
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S, Source

if TYPE_CHECKING:
    from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
    from modallab_simulators.ni_daqmx_server.input_task import InputTask


STEP_V = 4.9
"""What the input's coupling capacitor is charged by when the excitation comes on."""
TIME_S = 0.454
"""Time constant of AC coupling: 4.9 V are 6.6 mV after 3 s."""


@dataclass(frozen=True, slots=True)
class Supply:
    """One input's supply.

    Attributes:
        since_s: bench time since which the excitation is on; None: it is off.
        sensor: whether the sensor needs it.
    """

    since_s: float | None
    sensor: bool = True

    def seen(self, volts: Floats, times_s: Floats) -> Floats:
        """What the input sees of a sensor's `volts` at bench times: nothing without a supply."""
        if self.since_s is None:
            return np.zeros_like(volts) if self.sensor else volts
        return volts + STEP_V * np.exp(-np.maximum(times_s - self.since_s, 0.0) / TIME_S)


NOISE = 0.03
PERIOD = 100
"""Samples to a period of a made-up sine."""
LAG_TURNS = 5 / 360
NO_SOURCE = 10230


@dataclass(slots=True)
class ChannelSources:
    """The channels of one task, each from where it is connected.

    Attributes:
        channels: of the task.
        rows: of the bench, by the place of the channel in the task.
        bench: what stands behind those; None where there are none.
        loops: outputs by the place of the channel that looks at them.
        supplies: of IEPE sensors, by the place of the channel.
        rate_hz: of the samples in bench time.
        start_s: bench time of the first.
        now: of the bench, where samples are taken when they are asked for; such a conversion takes its time.
        set_points: of powers supplied, by the place of the channel.
    """

    channels: Sequence[InputChannel]
    rows: dict[int, int]
    bench: Source | None
    loops: dict[int, OutputLine]
    supplies: dict[int, Supply]
    rate_hz: float
    start_s: float
    set_points: dict[int, float]
    now: Callable[[], float] | None = None
    position: int = 0

    def take(self, count: int) -> tuple[Floats, NDArray[np.bool_]]:
        """See `Source`."""
        volts = np.zeros((len(self.channels), count))
        overload = np.zeros(volts.shape, dtype=np.bool_)
        places = self.position + np.arange(count)
        times = self.start_s + places / self.rate_hz
        self.position += count
        if self.bench is not None:
            found, over = self.bench.take(count)
            order, rows = list(self.rows), list(self.rows.values())
            volts[order], overload[order] = found[rows], over[rows]
        for place, line in self.loops.items():
            volts[place] = line.volts(times if self.now is None else np.full(count, self.now() + LATENCY_S))
        for place, supply in self.supplies.items():
            volts[place] = supply.seen(volts[place], times)
        for place, channel in enumerate(self.channels):
            if place in self.set_points:
                volts[place] = self.set_points[place]
            elif channel.module.simulated:
                volts[place] = _made_up(channel, place, places)
        return volts, overload

    def changed(self) -> None:
        """See `Source`."""
        if self.bench is not None:
            self.bench.changed()


def _made_up(channel: InputChannel, place: int, places: NDArray[np.int64]) -> Floats:
    # A full-scale sine with 3 % of noise that never leaves the limits of the channel.
    noise = np.random.default_rng((place, int(places[0]))).uniform(-NOISE, NOISE, len(places))
    sine = (1 - NOISE) * np.sin(2 * np.pi * (places / PERIOD + place * LAG_TURNS)) + noise
    middle, half = (channel.high + channel.low) / 2, (channel.high - channel.low) / 2
    return (middle + half * sine) / channel.per_volt


_LOOP = re.compile(r"(?P<device>[^/]+)/_(?P<output>ao\d+)_vs_aognd")


def channel_sources(system: "SimulatedSystem", task: "InputTask", rate_hz: float, start_s: float) -> ChannelSources:
    """What the channels of a task see from `start_s` on."""
    loops: dict[int, OutputLine] = {}
    rows: dict[int, int] = {}
    for place, channel in enumerate(task.channels):
        loop = _LOOP.fullmatch(channel.physical)
        if loop is not None:
            loops[place] = system.lines[f"{loop['device']}/{loop['output']}"]
        elif not channel.module.simulated and channel.physical in channel.module.input_names():
            rows[place] = system.row_of(channel.physical)
    supplies = {place: _supply(system, task, task.channels[place], start_s, row) for place, row in rows.items()}
    bench = system.plant.begin(rate_hz, start_s, system.shaker_lines) if rows else None
    known = {place: float(task.get("PWR_VOLTAGE_SETPOINT", 0.0, c.name))
             for place, c in enumerate(task.channels) if c.kind == "Power"}  # fmt: skip
    return ChannelSources(
        task.channels, rows, bench, loops, {p: s for p, s in supplies.items() if s is not None}, rate_hz, start_s,
        known, system.clock.now if task.timing == "on-demand" else None,
    )  # fmt: skip


def _supply(
    system: "SimulatedSystem", task: "InputTask", channel: InputChannel, start_s: float, row: int
) -> Supply | None:
    if not channel.module.iepe:
        return None
    current = float(task.get("AI_EXCIT_VAL", 0.0, channel.name))
    sensor = row < len(system.rig.channels) and system.rig.channels[row].coupling == "IEPE"
    if current <= 0 or task.get("AI_EXCIT_SRC", NO_SOURCE, channel.name) == NO_SOURCE:
        system.excited.pop(channel.physical, None)
        return Supply(None, sensor)
    return Supply(system.excited.setdefault(channel.physical, start_s), sensor)
