"""Digital input and output: ports and lines, at once or by a clock."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask
from modallab_simulators.ni_daqmx_server.signals import BenchClock
from modallab_simulators.ni_daqmx_server.tasks import Channel, Task

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
