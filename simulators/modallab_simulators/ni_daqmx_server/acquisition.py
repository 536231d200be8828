"""What all tasks that acquire have in common: a clock, a buffer that can overflow, and a place in it."""

from dataclasses import dataclass
from math import ceil, inf
from typing import Any

from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.signals import BenchClock
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Task

DEFAULT_BUFFER_S = 10.0


@dataclass(slots=True)
class AcquiringTask(Task):
    """A task that fills a buffer, sample by sample.

    Attributes:
        rate_hz: of its sample clock, as the device says it.
        true_hz: of its sample clock in bench time.
        finite: samples per channel after which it ends; 0: without end.
        buffer: samples per channel that are kept for the reader.
        position: of the next sample to be read.
        start_s: bench time of the first sample.
        triggered_s: bench time of its start trigger, which its converters may lag.
    """

    rate_hz: float = 1000.0
    true_hz: float = 1000.0
    finite: int = 0
    buffer: int = 0
    position: int = 0
    start_s: float = 0.0
    triggered_s: float = 0.0

    def set_clock(self, rate_hz: float, finite: int, buffer: int) -> None:
        """Set rate and length; `finite` 0 is without end."""
        self.rate_hz = self.true_hz = rate_hz
        self.finite = finite
        self.buffer = buffer or max(ceil(DEFAULT_BUFFER_S * self.rate_hz), finite)

    @property
    def untimed(self) -> bool:
        """Whether nothing paces it: it samples when it is read, as a simulated finite task does."""
        channels = self.all_channels()
        made_up = bool(channels) and all(c.module.simulated for c in channels)
        return self.timing == "on-demand" or (made_up and bool(self.finite))

    def begin(self, start_s: float, true_hz: float) -> None:
        """The first sample is at `start_s`."""
        self.start_s = self.triggered_s = start_s
        self.true_hz = true_hz
        if self.timing != "on-demand":
            self.position = 0
        self.running, self.waiting = True, False

    def acquired(self, clock: BenchClock) -> int:
        """Samples per channel acquired by now."""
        if not self.running or self.waiting:
            return self.position
        if self.untimed:
            return self.finite if self.timing != "on-demand" and self.finite else self.position
        if not clock.pace:
            return self.position
        count = max(0, int((clock.now() - self.start_s) * self.true_hz))
        return min(count, self.finite) if self.finite else count

    def due_s(self, count: int, clock: BenchClock) -> float:
        """How long until `count` more samples are there."""
        if self.waiting:
            return inf
        if not clock.pace or self.untimed:
            return 0.0
        return self.start_s + (self.position + count) / self.true_hz - clock.now()

    def done(self, clock: BenchClock) -> bool:
        """Whether it has acquired all it had to."""
        if not self.running or self.timing == "on-demand":
            return True
        return bool(self.finite) and not self.waiting and self.has_all(clock)

    def has_all(self, clock: BenchClock) -> bool:
        """Whether all samples of a finite task are there."""
        return self.untimed or not clock.pace or self.acquired(clock) >= self.finite

    def left(self, clock: BenchClock) -> int:
        """Samples that a read of all that is available gives: of a finite task all that are still to come."""
        if self.timing == "on-demand":
            return 1
        return self.finite - self.position if self.finite else self.acquired(clock) - self.position

    def take(self, count: int, clock: BenchClock) -> NDArray[Any]:
        """The next (channels, n <= count) values that are there.

        Raises:
            StatusError: overwritten, or never to come.
        """
        if not self.running:
            raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}")
        if self.finite and self.timing != "on-demand":
            # Of a finite acquisition a reader gets what is left of it.
            if count > 0 and self.position >= self.finite:
                raise StatusError(status.NEVER_AVAILABLE, f"Task Name: {self.name}", samples=0)
            count = min(count, self.finite - self.position)
        if clock.pace and not self.untimed:
            there = self.acquired(clock) - self.position
            if there > self.buffer:
                raise StatusError(status.NO_LONGER_AVAILABLE, f"Task Name: {self.name}", samples=0)
            count = min(count, max(there, 0))
        return self.next_values(count, clock)

    def next_values(self, count: int, clock: BenchClock) -> NDArray[Any]:
        """The next values, which are there."""
        raise NotImplementedError

    def advance(self, count: int, clock: BenchClock) -> None:
        """So many samples were read."""
        self.position += count
        clock.read_up_to(self.start_s + self.position / self.true_hz)
