"""What every task has: a name, a place among the others, and what it holds reserved."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from modallab_simulators.ni_daqmx_server.modules import Module
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

    def routed(self, attribute: str) -> str:
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
