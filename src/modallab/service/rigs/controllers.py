"""All rigs of a service, behind one `Control`."""

import re
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from modallab.acquisition.process.trip import Trip
from modallab.core.documents.queue import ConsentRequest, ConsentView
from modallab.core.documents.runs import Command
from modallab.core.errors import ModallabError
from modallab.core.rig import Rig
from modallab.service.errors import LeaseNeededError, NotFoundError
from modallab.service.records.leases import RigLeases
from modallab.service.rigs.control import Consent, ControllerState, RigConsents, StartRun
from modallab.service.rigs.controller import RigController


class RigControllers:
    """The rigs by id. The lease is looked at here, last of all, so that no delay on the way outlives it."""

    def __init__(self, controllers: Sequence[RigController], leases: RigLeases) -> None:
        self._controllers = {controller.bench.id: controller for controller in controllers}
        self._leases = leases
        self.others: Callable[[], dict[str, int]] = dict
        self.consents = RigConsents()

    def states(self) -> tuple[ControllerState, ...]:
        """How every rig stands."""
        return tuple(controller.state() for controller in self._controllers.values())

    def processes(self) -> dict[str, int]:
        """As `Control`."""
        return self.rig_processes() | self.others()

    def rig_processes(self) -> dict[str, int]:
        """As `processes`: those of the rigs."""
        return {f"rig {rig}": one.pid for rig, one in self._controllers.items() if one.pid is not None}

    def pid(self, rig: str) -> int | None:
        """The system's number of a rig's process."""
        return self._controller(rig).pid

    def trip(self, rig: str) -> Trip | None:
        """Why a rig may not be driven; None if it may."""
        return self._controller(rig).latch.read()

    def give_consent(self, rig: str, new: ConsentRequest, items: tuple[str, ...], lease: str | None) -> ConsentView:
        """Let queued runs begin by themselves. Raises as `Control`."""
        controller = self._controller(rig)
        held = self._leases.require(rig, lease)
        return self.consents.give(rig, new, frozenset(items), held, controller.pid).view

    def withdraw_consent(self, rig: str) -> None:
        """Let nothing begin by itself. Raises as `Control`."""
        self.consents.withdraw(self._controller(rig).bench.id)

    def consent_view(self, rig: str) -> ConsentView | None:
        """As `Control`."""
        consent = self.consent(self._controller(rig).bench.id)
        return None if consent is None else consent.view

    def consent(self, rig: str) -> Consent | None:
        """What may begin by itself now, as long as the lease it was given under is held.

        Raises:
            StorageError: that cannot be looked up.
        """
        consent = self.consents.get(rig)
        if consent is None:
            return None
        try:
            self._leases.require(rig, consent.lease)
        except LeaseNeededError:
            self.consents.withdraw(rig)
            return None
        return consent

    def start(self, order: StartRun) -> str:
        """Begin a run by hand; returns its name. What was to begin by itself then needs another consent.

        Raises as `Control`.
        """
        self.consents.withdraw(order.rig)
        return self.start_queued(order)

    def start_queued(self, order: StartRun) -> str:
        """Begin a run; returns its name. Raises as `Control`."""
        controller = self._controller(order.rig)
        lease = self._leases.require(order.rig, order.lease)
        return controller.start(order, lease.operator)

    def command(self, rig: str, run: str, command: Command, lease: str | None) -> None:
        """Pass a command on to an active run. Raises as `Control`."""
        controller = self._controller(rig)
        controller.command(run, command, self._leases.require(rig, lease).operator)

    def emergency_stop(self, rig: str | None, reason: str, operator: str) -> tuple[str, ...]:
        """Bring outputs to 0 V and latch; all rigs at once, none waits for another.

        Raises:
            NotFoundError: no rig of this id.
            ModallabError: an output could not be reached; the others were tried all the same.
        """
        controllers = list(self._controllers.values()) if rig is None else [self._controller(rig)]
        return self._stop(controllers, lambda controller: controller.emergency_stop(reason, operator))

    def trip_driving(self, reason: str) -> tuple[str, ...]:
        """Stop every rig whose output may move; for whoever misses a heartbeat."""
        controllers = [controller for controller in self._controllers.values() if controller.driving]
        return self._stop(controllers, lambda controller: controller.emergency_stop(reason, "heartbeat"))

    def reset(self, rig: str, reason: str, lease: str | None) -> None:
        """Let a tripped rig be driven again. Raises as `Control`."""
        controller = self._controller(rig)
        controller.reset(reason, self._leases.require(rig, lease).operator)

    def revise(self, rig: str, description: Rig, reason: str, lease: str | None) -> None:
        """Go on with another description. Raises as `Control`."""
        controller = self._controller(rig)
        controller.revise(description, reason, self._leases.require(rig, lease).operator)

    def replace(self, controller: RigController) -> None:
        """Put a controller in the place of a closed one of the same rig, whose sensors were moved."""
        self._controllers[controller.bench.id] = controller

    def request_close(self) -> None:
        """Have every rig left at rest; waits for nothing."""
        for controller in self._controllers.values():
            controller.request_close()

    def close(self) -> None:
        """Leave every rig at rest; none waits for another."""
        self.request_close()
        for controller in self._controllers.values():
            controller.close()

    def _controller(self, rig: str) -> RigController:
        if rig not in self._controllers:
            known = ", ".join(self._controllers) or "none"
            raise NotFoundError(f"there is no rig {rig!r}", remedy=f"this service has: {known}")
        return self._controllers[rig]

    def _stop(self, controllers: Sequence[RigController], stop: Callable[[RigController], None]) -> tuple[str, ...]:
        failed: ModallabError | None = None
        if not controllers:
            return ()
        for controller in controllers:
            self.consents.stop(controller.bench.id)
        with ThreadPoolExecutor(max_workers=len(controllers)) as pool:
            for future in [pool.submit(stop, controller) for controller in controllers]:
                try:
                    future.result()
                except ModallabError as error:
                    failed = error
        if failed is not None:
            raise failed
        return tuple(controller.bench.id for controller in controllers)


def rig_ids(names: Sequence[str]) -> tuple[str, ...]:
    """An id for each rig, from its name: lower case, words joined by hyphens, never twice the same."""
    found: list[str] = []
    for name in names:
        base = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:48] or "rig"
        number = 1 + sum(other == base or other.startswith(f"{base}--") for other in found)
        found.append(base if number == 1 else f"{base}--{number}")
    return tuple(found)
