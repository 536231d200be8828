"""What can be asked of the rigs, wherever they are driven from: in this process or in the service's supervisor."""

from dataclasses import dataclass
from typing import Protocol

from modallab.bench.protocol import BenchInfo
from modallab.core.documents.rigs import RigState
from modallab.core.documents.runs import Command
from modallab.core.plan import Plan
from modallab.core.rig import Rig


@dataclass(frozen=True, slots=True)
class StartRun:
    """Begin a run.

    Attributes:
        rig: id of the rig.
        campaign: id of the campaign.
        plan: what to do.
        lease: id of the rig's lease.
        continues: the run whose good blocks it takes over.
    """

    rig: str
    campaign: str
    plan: Plan
    lease: str | None
    continues: str | None = None


@dataclass(frozen=True, slots=True)
class ControllerState:
    """How a rig's process stands.

    Attributes:
        id: of the rig.
        rig: as believed.
        bench: address.
        state: of its process.
        info: what the bench said of itself; None until it is open.
        run: the active run.
        error: why it is unavailable.
    """

    id: str
    rig: Rig
    bench: str
    state: RigState
    info: BenchInfo | None
    run: str | None
    error: str


class Control(Protocol):
    """Commands to the rigs. Those that move something need the rig's lease; an emergency stop needs none."""

    def states(self) -> tuple[ControllerState, ...]:
        """How every rig stands."""
        ...

    def processes(self) -> dict[str, int]:
        """The processes of the service that live, by name, each with the system's number for it."""
        ...

    def start(self, order: StartRun) -> str:
        """Begin a run; returns its name once it has one.

        Raises:
            LeaseNeededError, TrippedError, ConflictError, RigUnavailableError, PlanError, StorageError.
        """
        ...

    def command(self, rig: str, run: str, command: Command, lease: str | None) -> None:
        """Send a command to an active run.

        Raises:
            LeaseNeededError, IllegalTransitionError, ConflictError.
        """
        ...

    def emergency_stop(self, rig: str | None, reason: str, operator: str) -> tuple[str, ...]:
        """Bring the output of a rig, or of every rig, to 0 V and latch; returns their ids."""
        ...

    def reset(self, rig: str, reason: str, lease: str | None) -> None:
        """Let a tripped rig be driven again.

        Raises:
            LeaseNeededError, NotFoundError.
        """
        ...
