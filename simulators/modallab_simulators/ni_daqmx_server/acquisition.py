"""What all tasks that acquire have in common: a clock, a buffer that can overflow, and a place in it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, inf
from typing import Any, Literal

from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.signals import BenchClock
from modallab_simulators.ni_daqmx_server.status import DEVICE_GONE, RESERVED, StatusError

Timing = Literal["on-demand", "clocked", "implicit"]


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel of a task.

    Attributes:
        name: the task's name of it.
        physical: its device's name of it; several lines, joined by commas, can make one channel.
        module: it belongs to.
        wave_order: of its lines in a waveform, where it is another one: ports begin with their last line.
    """

    name: str
    physical: str
    module: Module
    wave_order: tuple[int, ...] = ()


@dataclass(slots=True)
class Task:
    """One task on the server. It lives until it is cleared, whoever made it.

    Attributes:
        name: of the session.
        resources: what it needs for itself alone while it runs.
        running: whether it was started and not stopped.
        attributes: what clients have set, by channel and the attribute's name.
        timing: what paces it.
        waiting: whether it was started and waits for its start trigger or its clock.
        kept: whether it was reserved or committed by itself: a stop leaves it so.
        runs: how often it was started.
        events: kinds of events that somebody has registered for.
    """

    name: str
    resources: set[str] = field(default_factory=set[str])
    running: bool = False
    attributes: dict[tuple[str, str], Any] = field(default_factory=dict[tuple[str, str], Any])
    timing: Timing = "on-demand"
    waiting: bool = False
    kept: bool = False
    runs: int = 0
    events: dict[str, int] = field(default_factory=dict[str, int])

    def all_channels(self) -> Sequence[Channel]:
        """Its channels, in order."""
        return ()

    def get(self, attribute: str, default: Any = None, channel: str = "") -> Any:
        """What was set, or a default."""
        return self.attributes.get((channel, attribute), default)

    def full_terminal(self, attribute: str) -> str:
        """A terminal that was set, in full."""
        return terminal(str(self.get(attribute, "")), self.default_device)

    @property
    def default_device(self) -> str:
        """The device whose terminals are meant where none is named: the chassis, or that of the first channel."""
        channels = self.all_channels()
        return (channels[0].module.chassis or channels[0].module.name) if channels else ""

    @property
    def devices(self) -> set[str]:
        """Names of the devices it runs on."""
        return {resource.partition("/")[0] for resource in self.resources}


class Reservations:
    """Which task holds what, and which devices are there at all."""

    def __init__(self) -> None:
        self._holders: dict[str, str] = {}
        self.gone: dict[str, int] = {}

    def take(self, task: Task) -> None:
        """Reserve what a task needs.

        Raises:
            StatusError: a device is gone, or another task holds something.
        """
        self.require_present(task)
        for resource in sorted(task.resources):
            holder = self._holders.get(resource)
            if holder is not None and holder != task.name:
                raise StatusError(RESERVED, f"Resource: {resource}\nReserved by task: {holder}")
        self._holders.update(dict.fromkeys(task.resources, task.name))

    def hold(self, resource: str, holder: str) -> None:
        """Another program takes a resource."""
        self._holders[resource] = holder

    def drop(self, resource: str) -> None:
        """Whoever holds a resource gives it back."""
        self._holders.pop(resource, None)

    def release(self, task: Task) -> None:
        """Give back what a task holds."""
        self._holders = {resource: holder for resource, holder in self._holders.items() if holder != task.name}

    def require_present(self, task: Task) -> None:
        """Raise if a device is gone.

        Raises:
            StatusError: with the code the device left with.
        """
        for device in sorted(task.devices & set(self.gone)):
            raise StatusError(self.gone.get(device, DEVICE_GONE), f"Device: {device}")


def terminal(source: str, device: str) -> str:
    """The full name of a terminal: `/Dev1/PFI0` for `PFI0` of Dev1; "" stays."""
    return source if not source or source.startswith("/") else f"/{device}/{source}"


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
