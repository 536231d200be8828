"""All rigs of a service, behind one `Control`."""

import re
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from modallab.campaign.control import DeskState, StartRun
from modallab.campaign.desk import Desk
from modallab.campaign.errors import NotFoundError
from modallab.campaign.rig_lease import Leases
from modallab.errors import ModallabError
from modallab.schema.service.runs import Command


class Desks:
    """The rigs by id. The lease is looked at here, last of all, so that no delay on the way outlives it."""

    def __init__(self, desks: Sequence[Desk], leases: Leases) -> None:
        self._desks = {desk.bench.id: desk for desk in desks}
        self._leases = leases
        self.others: Callable[[], dict[str, int]] = dict

    def states(self) -> tuple[DeskState, ...]:
        """How every rig stands."""
        return tuple(desk.state() for desk in self._desks.values())

    def processes(self) -> dict[str, int]:
        """As `Control`."""
        rigs = {f"rig {rig}": desk.pid for rig, desk in self._desks.items() if desk.pid is not None}
        return rigs | self.others()

    def start(self, order: StartRun) -> str:
        """Begin a run; returns its name. Raises as `Control`."""
        desk = self._desk(order.rig)
        lease = self._leases.require(order.rig, order.lease)
        return desk.start(order, lease.operator)

    def command(self, rig: str, run: str, command: Command, lease: str | None) -> None:
        """Tell an active run something. Raises as `Control`."""
        desk = self._desk(rig)
        desk.command(run, command, self._leases.require(rig, lease).operator)

    def emergency_stop(self, rig: str | None, reason: str, operator: str) -> tuple[str, ...]:
        """Bring outputs to 0 V and latch; all rigs at once, none waits for another.

        Raises:
            NotFoundError: no rig of this id.
            ModallabError: an output could not be reached; the others were tried all the same.
        """
        desks = list(self._desks.values()) if rig is None else [self._desk(rig)]
        return self._stop(desks, lambda desk: desk.emergency_stop(reason, operator))

    def trip_driving(self, reason: str) -> tuple[str, ...]:
        """Stop every rig whose output may move; for whoever misses a heartbeat."""
        desks = [desk for desk in self._desks.values() if desk.driving]
        return self._stop(desks, lambda desk: desk.emergency_stop(reason, "heartbeat"))

    def reset(self, rig: str, reason: str, lease: str | None) -> None:
        """Let a tripped rig be driven again. Raises as `Control`."""
        desk = self._desk(rig)
        desk.reset(reason, self._leases.require(rig, lease).operator)

    def close(self) -> None:
        """Leave every rig at rest."""
        for desk in self._desks.values():
            desk.close()

    def _desk(self, rig: str) -> Desk:
        if rig not in self._desks:
            known = ", ".join(self._desks) or "none"
            raise NotFoundError(f"there is no rig {rig!r}", remedy=f"this service has: {known}")
        return self._desks[rig]

    @staticmethod
    def _stop(desks: Sequence[Desk], stop: Callable[[Desk], None]) -> tuple[str, ...]:
        failed: ModallabError | None = None
        if not desks:
            return ()
        with ThreadPoolExecutor(max_workers=len(desks)) as pool:
            for future in [pool.submit(stop, desk) for desk in desks]:
                try:
                    future.result()
                except ModallabError as error:
                    failed = error
        if failed is not None:
            raise failed
        return tuple(desk.bench.id for desk in desks)


def rig_ids(names: Sequence[str]) -> tuple[str, ...]:
    """An id for each rig, from its name: lower case, words joined by hyphens, never twice the same."""
    found: list[str] = []
    for name in names:
        base = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:48] or "rig"
        number = 1 + sum(other == base or other.startswith(f"{base}--") for other in found)
        found.append(base if number == 1 else f"{base}--{number}")
    return tuple(found)
