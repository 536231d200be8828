"""Tasks of digital lines and of counters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel, Task, terminal
from modallab_simulators.ni_daqmx_server.signals import BenchClock, Pulses

TICKS_HZ = 100e6


@dataclass(slots=True)
class CounterInputTask(AcquiringTask):
    """Counters that measure what is on a terminal.

    Attributes:
        channels: one counter each.
        kind: what is measured, as the call that made the channel names it.
        pulses: finds what is on a terminal now.
    """

    channels: list[Channel] = field(default_factory=list[Channel])
    kind: str = "CountEdges"
    pulses: Callable[[str], Pulses | None] = lambda source: None

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    @property
    def is_simulated(self) -> bool:
        """Whether the driver itself makes the device up; it then counts 0 for ever."""
        return all(c.module.simulated for c in self.channels)

    def measured(self, channel: Channel) -> Pulses | None:
        """What is on the terminal that a channel measures."""
        set_terminals = [v for (c, name), v in self.attributes.items() if c in (channel.name, "") and _measures(name)]
        wired = set_terminals[-1] if set_terminals else f"{channel.physical}/source"
        return self.pulses(terminal(str(wired), channel.module.chassis or channel.module.name))

    def due_s(self, count: int, clock: BenchClock) -> float:
        """How long until `count` more samples are there; a measurement waits for the pulse it measures."""
        needs_signal = self.kind != "CountEdges" or self.timing == "implicit"
        pulses = self.measured(self.channels[0])
        if needs_signal and pulses is None and not self.is_simulated:
            return np.inf
        if self.timing == "implicit" and pulses is not None and clock.pace:
            return self.start_s + (self.position + count) / pulses.frequency_hz - clock.now()
        return AcquiringTask.due_s(self, count, clock)

    def acquired(self, clock: BenchClock) -> int:
        """Samples per channel acquired by now."""
        pulses = self.measured(self.channels[0])
        if self.timing != "implicit" or pulses is None or not clock.pace or not self.running:
            return AcquiringTask.acquired(self, clock)
        count = max(0, int((clock.now() - self.start_s) * pulses.frequency_hz))
        return min(count, self.finite) if self.finite else count

    def next_values(self, count: int, clock: BenchClock) -> NDArray[Any]:
        """The next (channels, count, 2) values: first and second of a pair, or count and 0."""
        first = self.position
        places = np.arange(first, first + count)
        self.advance(count, clock)
        times = self.start_s + places / self.true_hz if self.timing == "clocked" else np.full(count, clock.now())
        return np.stack([self._channel(c, times) for c in self.channels])

    def _channel(self, channel: Channel, times: NDArray[np.float64]) -> NDArray[np.float64]:
        pulses = self.measured(channel)
        found = np.zeros((len(times), 2))
        if pulses is None:
            return found + (self.get("CI_COUNT_EDGES_INITIAL_CNT", 0, channel.name) if self.kind == "CountEdges" else 0)
        if self.kind == "CountEdges":
            found[:, 0] = self._counts(channel, pulses, times)
            return found
        found[:] = _pair(self.kind, pulses)
        return found

    def _counts(self, channel: Channel, pulses: Pulses, times: NDArray[np.float64]) -> NDArray[np.float64]:
        before = pulses.edges_until(self.start_s)
        up = np.array([pulses.edges_until(t) - before for t in times], dtype=np.float64)
        down = self.get("CI_COUNT_EDGES_DIR", 10128, channel.name) == 10124
        first = self.get("CI_COUNT_EDGES_INITIAL_CNT", 0, channel.name)
        return (first + (-up if down else up)) % 2**32


def _measures(name: str) -> bool:
    return name.startswith("CI_") and name.endswith("_TERM") and "THRESH" not in name


def _pair(kind: str, pulses: Pulses) -> tuple[float, float]:
    period_s = 1 / pulses.frequency_hz
    high_s, low_s = period_s * pulses.duty, period_s * (1 - pulses.duty)
    known = {
        "Freq": (pulses.frequency_hz, 0.0),
        "Period": (period_s, 0.0),
        "PulseWidth": (high_s, 0.0),
        "SemiPeriod": (high_s, 0.0),
        "DutyCycle": (pulses.duty, 0.0),
        "PulseFreq": (pulses.frequency_hz, pulses.duty),
        "PulseTime": (high_s, low_s),
        "PulseTicks": (round(high_s * TICKS_HZ), round(low_s * TICKS_HZ)),
    }
    return known.get(kind, (0.0, 0.0))


@dataclass(slots=True)
class CounterOutputTask(Task):
    """Counters that give out pulses.

    Attributes:
        channels: one counter each.
        trains: frequency in Hz and duty cycle by channel: those that were written last.
        finite: how many pulses; 0: without end.
        start_s: bench time of the start.
    """

    channels: list[Channel] = field(default_factory=list[Channel])
    trains: dict[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])
    finite: int = 1
    start_s: float = 0.0

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    def pulses(self, channel: Channel) -> Pulses | None:
        """What a channel gives out; None while it does not run."""
        if not self.running or self.waiting:
            return None
        frequency_hz, duty = self.trains[channel.name]
        initial_s = float(self.get("CO_PULSE_FREQ_INITIAL_DELAY", 0.0, channel.name))
        low_s = (1 - duty) / frequency_hz
        return Pulses(self.start_s + max(initial_s, low_s), frequency_hz, duty, self.finite or np.inf)

    def done(self, clock: BenchClock) -> bool:
        """Whether all pulses were given out."""
        if not self.running:
            return True
        if not self.finite or self.waiting:
            return False
        if all(c.module.simulated for c in self.channels):
            return True
        frequency_hz, _ = self.trains[self.channels[0].name]
        return not clock.pace or clock.now() >= self.start_s + self.finite / frequency_hz


BYTE = 8


def line_number(line: str) -> int:
    """Place of a line in its port."""
    return int(line.rpartition("line")[2])


@dataclass(slots=True)
class DigitalInputTask(AcquiringTask):
    """Digital lines that are read, one or more to a channel.

    Attributes:
        channels: each with its lines, joined by commas.
        level: what stands on a line at a time.
    """

    channels: list[Channel] = field(default_factory=list[Channel])
    level: Callable[[str, float], bool] = lambda line, at_s: False

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    def next_values(self, count: int, clock: BenchClock) -> NDArray[Any]:
        """The next values, which are there: one number a channel, its first line the lowest bit."""
        first = self.position
        self.advance(count, clock)
        places = np.arange(first, first + count, dtype=np.uint32)
        return np.stack([self._channel(c, places) for c in self.channels])

    def _channel(self, channel: Channel, places: NDArray[np.uint32]) -> NDArray[np.uint32]:
        found = np.zeros(places.shape, dtype=np.uint32)
        for bit, line in enumerate(channel.physical.split(",")):
            found |= self._line(channel, line, places) << np.uint32(bit)
        return found

    def _line(self, channel: Channel, line: str, places: NDArray[np.uint32]) -> NDArray[np.uint32]:
        if channel.module.simulated:
            # The driver makes up a binary counter of each eight lines.
            return (places >> np.uint32(line_number(line) % BYTE)) & np.uint32(1)
        if self.timing == "on-demand":
            return np.full(places.shape, int(self.level(line, np.inf)), dtype=np.uint32)
        times = self.start_s + places / self.true_hz
        return np.array([int(self.level(line, t)) for t in times], dtype=np.uint32)


Levels = NDArray[np.bool_]


@dataclass(slots=True)
class LineTask(Task):
    """Digital lines, of which the changes are counted.

    Attributes:
        channels: each with its lines, joined by commas.
        levels: what stands on every line of the system; it outlives the task.
        pattern: (samples, lines) played by a clock; None: lines are set at once.
        rate_hz: of the clock; 0: there is none.
        finite: samples after which it ends; 0: it is played again and again.
    """

    channels: list[Channel] = field(default_factory=list[Channel])
    levels: dict[str, bool] = field(default_factory=dict[str, bool])
    changes: int = 0
    pattern: Levels | None = None
    rate_hz: float = 0.0
    finite: int = 0
    start_s: float = 0.0

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return self.channels

    @property
    def lines(self) -> tuple[str, ...]:
        """All lines, in order."""
        return tuple(line for channel in self.channels for line in channel.physical.split(","))

    def write(self, samples: Levels) -> None:
        """Set the lines, or fill the buffer; `samples` is (samples, lines)."""
        if self.rate_hz:
            self.pattern = samples
            return
        for line, level in zip(self.lines, samples[-1], strict=True):
            if bool(level) != self.levels.get(line, False):
                self.changes += 1
            self.levels[line] = bool(level)

    def level(self, line: str, at_s: float) -> bool:
        """What the task puts on a line of it at a bench time."""
        if self.pattern is None or not self.running or self.waiting or at_s < self.start_s:
            return self.levels.get(line, False)
        place = int((at_s - self.start_s) * self.rate_hz + 1e-6) if np.isfinite(at_s) else len(self.pattern)
        last = len(self.pattern) - 1
        place = min(place, last) if self.finite else place % len(self.pattern)
        return bool(self.pattern[place, self.lines.index(line)])

    def stop(self) -> None:
        """Stop playing: the last levels stay."""
        if self.pattern is not None and self.running and not self.waiting:
            for line in self.lines:
                self.levels[line] = self.level(line, np.inf)

    def done(self, clock: BenchClock) -> bool:
        """Whether a finite pattern was played."""
        if not self.running or not self.rate_hz:
            return True
        made_up = all(c.module.simulated for c in self.channels)
        ended = made_up or not clock.pace or clock.now() >= self.start_s + self.finite / self.rate_hz
        return bool(self.finite) and not self.waiting and ended
