"""Digital input: ports and lines, at once or by a clock."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask
from modallab_simulators.ni_daqmx_server.clock import BenchClock
from modallab_simulators.ni_daqmx_server.tasks import Channel

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
