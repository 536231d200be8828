"""Analog input: continuous or finite, with a buffer that can overflow and a reference trigger."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.clock import BenchClock
from modallab_simulators.ni_daqmx_server.delays import DelayedSource
from modallab_simulators.ni_daqmx_server.lines import Floats, OutputLine
from modallab_simulators.ni_daqmx_server.modules import Module, coerced
from modallab_simulators.ni_daqmx_server.plant import Plant
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.supply import AC, Supplies
from modallab_simulators.ni_daqmx_server.tasks import Task

DEFAULT_BUFFER_S = 10.0
TRIGGER_PIECE = 256


@dataclass(frozen=True, slots=True)
class InputChannel:
    """One channel of an input task.

    Attributes:
        physical: its device's name of it.
        row: of the plant.
        module: it belongs to.
        per_volt: engineering units per volt.
        fed: whether the input feeds an IEPE sensor.
    """

    physical: str
    row: int
    module: Module
    per_volt: float
    fed: bool = False


@dataclass(frozen=True, slots=True)
class ReferenceTrigger:
    """Keep so many samples before the first crossing of a level, once that many have come."""

    channel: int
    level: float
    rising: bool
    pre_trigger: int


@dataclass(slots=True)
class InputTask(Task):
    """Inputs of one device or chassis, sampled by one clock."""

    channels: list[InputChannel] = field(default_factory=list[InputChannel])
    rate_hz: float = 1000.0
    finite: int = 0
    buffer: int = 0
    trigger: ReferenceTrigger | None = None
    position: int = 0
    start_s: float = 0.0
    overload: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    dead: set[int] = field(default_factory=set[int])
    shunted: set[int] = field(default_factory=set[int])
    source: DelayedSource | None = None
    record: list[Floats] = field(default_factory=list[Floats])
    ready: bool = False
    supplies: Supplies = field(default_factory=Supplies)

    @property
    def fed(self) -> set[str]:
        """Inputs that feed a sensor."""
        set_to = {name for (name, number), value in self.attributes.items() if number == 0x17F5 and value}
        return {channel.physical for channel in self.channels if channel.fed or channel.physical in set_to}

    def set_clock(self, rate_hz: float, finite: int, buffer: int) -> None:
        """Set rate and length; `finite` 0 is without end."""
        self.rate_hz = coerced(self.modules, len(self.channels), rate_hz)
        self.finite = finite
        self.buffer = buffer or max(ceil(DEFAULT_BUFFER_S * self.rate_hz), finite)

    @property
    def modules(self) -> tuple[Module, ...]:
        """The modules its channels belong to."""
        return tuple({channel.module.name: channel.module for channel in self.channels}.values())

    def convert_rate_hz(self) -> float:
        """Rate of the multiplexer; the sample rate where each channel has its own converter."""
        shared = [m for m in self.modules if m.multiplexed]
        return shared[0].convert_rate_hz(len(self.channels), self.rate_hz) if shared else self.rate_hz

    def start(self, plant: Plant, line: OutputLine, clock: BenchClock) -> None:
        """Begin to sample now."""
        self.start_s, self.position, self.ready = clock.now(), 0, False
        self.record = []
        self.overload = np.zeros(len(self.channels), dtype=np.bool_)
        turns = [n * self.rate_hz / self.convert_rate_hz() if c.module.multiplexed else 0.0 for n, c in self._numbered]
        self.source = DelayedSource(
            lambda before: plant.begin(self.rate_hz, self.start_s - before / self.rate_hz, line),
            [c.row for c in self.channels],
            [c.module.delay_samples for c in self.channels],
            turns,
        )
        self.running = True

    def acquired(self, clock: BenchClock) -> int:
        """Samples per channel acquired by now."""
        if not clock.pace or not self.running:
            return self.position
        count = int((clock.now() - self.start_s) * self.rate_hz)
        return min(count, self.finite) if self.finite and self.trigger is None else count

    def due_s(self, count: int, clock: BenchClock) -> float:
        """How long until `count` more samples are there."""
        if not clock.pace or (self.trigger is not None and self.ready):
            return 0.0
        return self.start_s + (self.position + count) / self.rate_hz - clock.now()

    def take(self, count: int, clock: BenchClock) -> Floats:
        """The next (channels, n <= count) values that are there.

        Raises:
            StatusError: overwritten, or never to come.
        """
        if self.source is None or not self.running:
            raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}")
        if self.trigger is not None:
            return self._take_triggered(count, clock)
        if self.finite and self.position + count > self.finite:
            raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}", samples=0)
        there = self.acquired(clock) - self.position
        if clock.pace and there > self.buffer:
            raise StatusError(status.NO_LONGER_AVAILABLE, f"Task Name: {self.name}", samples=0)
        return self._next(count if not clock.pace else max(0, min(count, there)), clock)

    def _next(self, count: int, clock: BenchClock) -> Floats:
        assert self.source is not None
        if count == 0:
            return np.zeros((len(self.channels), 0))
        volts, overload = self.source.take(count)
        volts, overload = self._with_bias(volts, overload)
        self.overload |= overload
        self.position += count
        clock.read_up_to(self.start_s + self.position / self.rate_hz)
        values = volts * np.array([c.per_volt for c in self.channels])[:, None]
        values[list(self.dead)] = 0.0
        return values

    def _with_bias(self, volts: Floats, overload: NDArray[np.bool_]) -> tuple[Floats, NDArray[np.bool_]]:
        fed = self.fed
        if not fed:
            return volts, overload
        times_s = self.start_s + (self.position + np.arange(volts.shape[1])) / self.rate_hz
        volts, overload = volts.copy(), overload.copy()
        for row, channel in enumerate(self.channels):
            if channel.physical in fed:
                ac = self.attributes.get((channel.physical, 0x64), channel.module.coupling) == AC
                range_v = channel.module.input_range_v
                volts[row] += self.supplies.bias_v(channel.physical, times_s, ac=ac)
                overload[row] |= bool(np.abs(volts[row]).max(initial=0.0) >= range_v)
                volts[row] = np.clip(volts[row], -range_v, range_v)
        return volts, overload

    def _take_triggered(self, count: int, clock: BenchClock) -> Floats:
        if not self.ready:
            self._look_for_trigger(clock)
        if not self.ready:
            return np.zeros((len(self.channels), 0))
        whole = self.record[0]
        if whole.shape[1] < count:
            raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}", samples=0)
        self.record = [whole[:, count:]]
        return whole[:, :count]

    def _look_for_trigger(self, clock: BenchClock) -> None:
        # Without pace, a second of bench time a look; with it, what has come by now.
        assert self.trigger is not None
        there = self.acquired(clock) - self.position if clock.pace else ceil(self.rate_hz)
        while there >= TRIGGER_PIECE and not self.ready:
            self.record.append(self._next(TRIGGER_PIECE, clock))
            there -= TRIGGER_PIECE
            whole = np.concatenate(self.record, axis=1)
            found = crossing(whole[self.trigger.channel], self.trigger)
            if found is not None and whole.shape[1] - found >= self.finite - self.trigger.pre_trigger:
                first = found - self.trigger.pre_trigger
                self.record, self.ready = [whole[:, first : first + self.finite]], True
            elif found is None:
                self.record = [whole[:, -self.trigger.pre_trigger - 1 :]]

    @property
    def _numbered(self) -> Sequence[tuple[int, InputChannel]]:
        return list(enumerate(self.channels))


def crossing(values: Floats, trigger: ReferenceTrigger) -> int | None:
    """Index of the first crossing after the pre-trigger is full; edges before it are ignored."""
    above = values >= trigger.level if trigger.rising else values <= trigger.level
    edges = np.flatnonzero(above[1:] & ~above[:-1]) + 1
    edges = edges[edges >= trigger.pre_trigger]
    return int(edges[0]) if edges.size else None
