"""Counters: edges counted, pulses measured, pulses generated."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask
from modallab_simulators.ni_daqmx_server.signals import BenchClock, Pulses
from modallab_simulators.ni_daqmx_server.tasks import Channel, Task, terminal

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
