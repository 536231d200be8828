"""What every task has: a name, a place among the others, and what it holds reserved."""

from dataclasses import dataclass, field

from modallab_simulators.ni_daqmx_server.status import BAD_ROUTE, DEVICE_GONE, RESERVED, StatusError


@dataclass(slots=True)
class Task:
    """One task on the server. It lives until it is cleared, whoever made it.

    Attributes:
        name: of the session.
        resources: what it needs for itself alone while it runs.
        running: whether it was started and not stopped.
        attributes: what clients have set, by channel and attribute.
        committed: whether it keeps what it needs when it is stopped.
    """

    name: str
    resources: set[str] = field(default_factory=set[str])
    running: bool = False
    attributes: dict[tuple[str, int], object] = field(default_factory=dict[tuple[str, int], object])
    committed: bool = False

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


def require_terminal(source: str) -> None:
    """Reject a clock or trigger terminal that no simulated device has.

    Raises:
        StatusError: there is no such terminal.
    """
    if source and not source.endswith(("SampleClock", "OnboardClock", "StartTrigger")):
        raise StatusError(BAD_ROUTE, f"Source Terminal: {source}")
