"""Analog input: continuous or finite, with a buffer that can overflow and a reference trigger."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel
from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.modules import DelayedSource, Module, coerced_rate
from modallab_simulators.ni_daqmx_server.plant import Source
from modallab_simulators.ni_daqmx_server.signals import BenchClock
from modallab_simulators.ni_daqmx_server.status import StatusError

TRIGGER_PIECE = 256


@dataclass(frozen=True, slots=True)
class InputChannel(Channel):
    """One channel of an input task.

    Attributes:
        per_volt: engineering units per volt.
        scaled: from volts times that to a custom scale's units.
        low, high: limits that were set, in the channel's units.
        kind: what it measures, as the calls that make channels name it.
    """

    per_volt: float = 1.0
    scaled: Callable[[Floats], Floats] | None = None
    low: float = -10.0
    high: float = 10.0
    kind: str = "Voltage"


@dataclass(frozen=True, slots=True)
class ReferenceTrigger:
    """Keep so many samples before the first crossing of a level, once that many have come."""

    channel: int
    level: float
    rising: bool
    pre_trigger: int


@dataclass(slots=True)
class InputTask(AcquiringTask):
    """Inputs of one device or chassis, sampled by one clock."""

    channels: list[InputChannel] = field(default_factory=list[InputChannel])
    trigger: ReferenceTrigger | None = None
    trigger_s: float | None = None
    overload: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    dead: set[int] = field(default_factory=set[int])
    source: DelayedSource | None = None
    record: list[Floats] = field(default_factory=list[Floats])
    ready: bool = False

    def all_channels(self) -> Sequence[InputChannel]:
        """Its channels, in order."""
        return self.channels

    def set_clock(self, rate_hz: float, finite: int, buffer: int) -> None:
        """Set rate and length; the rate becomes one that the devices can give."""
        AcquiringTask.set_clock(self, coerced_rate(self.modules, len(self.channels), rate_hz), finite, buffer)

    @property
    def modules(self) -> tuple[Module, ...]:
        """The modules its channels belong to."""
        return tuple({channel.module.name: channel.module for channel in self.channels}.values())

    def convert_rate_hz(self) -> float:
        """Rate of the multiplexer; the sample rate where each channel has its own converter."""
        shared = [m for m in self.modules if m.multiplexed]
        return shared[0].convert_rate_hz(len(self.channels), self.rate_hz) if shared else self.rate_hz

    def sample(self, start_s: float, true_hz: float, begin: Callable[[float, float], Source]) -> None:
        """Begin to sample at `start_s`; `begin` makes the source, from its rate and start."""
        self.begin(start_s, true_hz)
        self.ready, self.record = False, []
        self.overload = np.zeros(len(self.channels), dtype=np.bool_)
        turns = [self._turn(n, c) for n, c in self._numbered]
        self.source = DelayedSource(
            lambda before: begin(true_hz, start_s - before / true_hz),
            list(range(len(self.channels))),
            [self.delay_of(c) for c in self.channels],
            turns,
        )

    def _turn(self, place: int, channel: InputChannel) -> float:
        # What the driver makes up, or an internal loop, or a sample on demand, has no turn at the multiplexer.
        own = channel.physical in channel.module.input_names() and not channel.module.simulated
        if not channel.module.multiplexed or not own or self.timing == "on-demand":
            return 0.0
        return place * self.rate_hz / self.convert_rate_hz()

    def delay_of(self, channel: InputChannel) -> int:
        """Samples by which a channel's digital filter lags, as far as the device does not take it out."""
        removed = self.get("AI_REMOVE_FILTER_DELAY", False, channel.name)
        return 0 if removed else channel.module.delay_samples

    def acquired(self, clock: BenchClock) -> int:
        """Samples per channel acquired by now; with a reference trigger, before and after it."""
        if self.trigger is None:
            return AcquiringTask.acquired(self, clock)
        if not clock.pace or not self.running:
            return self.position
        return int((clock.now() - self.start_s) * self.true_hz)

    def due_s(self, count: int, clock: BenchClock) -> float:
        """How long until `count` more samples are there."""
        if self.trigger is not None and self.ready:
            return 0.0
        return AcquiringTask.due_s(self, count, clock)

    def has_all(self, clock: BenchClock) -> bool:
        """Whether all samples of a finite task are there."""
        return self.ready if self.trigger is not None else AcquiringTask.has_all(self, clock)

    def left(self, clock: BenchClock) -> int:
        """Samples that a read of all gives; with a reference trigger all of its record, which may never come."""
        if self.trigger is None:
            return AcquiringTask.left(self, clock)
        return self.record[0].shape[1] if self.ready else self.finite

    def take(self, count: int, clock: BenchClock) -> Floats:
        """The next (channels, n <= count) values that are there.

        Raises:
            StatusError: overwritten, or never to come.
        """
        if self.source is None:
            raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}")
        if self.trigger is not None and self.running:
            return self._take_triggered(count, clock)
        return AcquiringTask.take(self, count, clock)

    def next_values(self, count: int, clock: BenchClock) -> Floats:
        """The next values, which are there."""
        assert self.source is not None
        if count == 0:
            return np.zeros((len(self.channels), 0))
        volts, overload = self.source.take(count)
        self.overload |= overload
        self.advance(count, clock)
        values = volts * np.array([c.per_volt for c in self.channels])[:, None]
        for place, channel in self._numbered:
            if channel.scaled is not None:
                values[place] = channel.scaled(values[place])
        values[list(self.dead)] = 0.0
        return values

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
            self.record.append(self.next_values(TRIGGER_PIECE, clock))
            there -= TRIGGER_PIECE
            whole = np.concatenate(self.record, axis=1)
            found = self._crossing(whole)
            if found is not None and whole.shape[1] - found >= self.finite - self.trigger.pre_trigger:
                first = found - self.trigger.pre_trigger
                self.record, self.ready = [whole[:, first : first + self.finite]], True
            elif found is None:
                self.record = [whole[:, -self.trigger.pre_trigger - 1 :]]

    def _crossing(self, whole: Floats) -> int | None:
        assert self.trigger is not None
        if self.trigger.channel >= 0:
            return crossing(whole[self.trigger.channel], self.trigger)
        if self.trigger_s is None:
            return None
        first = self.position - whole.shape[1]
        place = ceil((self.trigger_s - self.start_s) * self.true_hz) - first
        return place if self.trigger.pre_trigger <= place < whole.shape[1] else None

    @property
    def _numbered(self) -> Sequence[tuple[int, InputChannel]]:
        return list(enumerate(self.channels))


def crossing(values: Floats, trigger: ReferenceTrigger) -> int | None:
    """Index of the first crossing after the pre-trigger is full; edges before it are ignored."""
    above = values >= trigger.level if trigger.rising else values <= trigger.level
    edges = np.flatnonzero(above[1:] & ~above[:-1]) + 1
    edges = edges[edges >= trigger.pre_trigger]
    return int(edges[0]) if edges.size else None
