"""What can be asked of the rigs, wherever they are driven from, and which steps a run may take."""

import time
from dataclasses import dataclass
from threading import Lock
from typing import Protocol

from modallab.acquisition.monitor.run_states import TRANSITIONS, IllegalTransitionError
from modallab.bench.protocol import BenchInfo
from modallab.core.documents.queue import ConsentRequest, ConsentView
from modallab.core.documents.rigs import Lease, RigState
from modallab.core.documents.runs import Action, Command
from modallab.core.events import RunState
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.service.records.repository import RunKey

REQUESTED: dict[Action, RunState] = {"pause": "paused", "resume": "acquiring", "stop": "stopping", "abort": "stopping"}
"""The state an action leads to; dropping and repeating lead to none."""
AT_WORK: frozenset[RunState] = frozenset({"armed", "acquiring", "paused"})
"""States in which a block can be asked for again."""


@dataclass(frozen=True, slots=True)
class StartRun:
    """Begin a run.

    Attributes:
        rig: id of the rig.
        campaign: id of the campaign.
        plan: plan of the run.
        lease: id of the rig's lease.
        continues: name of the continued run.
        key: under which it is begun once, however often it is asked for.
    """

    rig: str
    campaign: str
    plan: Plan
    lease: str | None
    continues: str | None = None
    key: RunKey | None = None


@dataclass(frozen=True, slots=True)
class ControllerState:
    """How a rig's process stands.

    Attributes:
        id: of the rig.
        rig: as believed.
        bench: address.
        state: state of the rig's process.
        info: what the bench said of itself; None until it is open.
        run: name of the active run.
        error: reason if the rig is unavailable.
        since: when it came to stand so, in UTC.
    """

    id: str
    rig: Rig
    bench: str
    state: RigState
    info: BenchInfo | None
    run: str | None
    error: str
    since: str = ""


class RigControl(Protocol):
    """Commands to the rigs. Those that move something need the rig's lease; an emergency stop needs none."""

    def states(self) -> tuple[ControllerState, ...]:
        """How every rig stands."""
        ...

    def processes(self) -> dict[str, int]:
        """The running processes of the service, by name, each with its process id."""
        ...

    def start(self, order: StartRun) -> str:
        """Begin a run; returns its name once it has one.

        Raises:
            LeaseNeededError, TrippedError, ConflictError, RigUnavailableError, PlanError, IdempotencyError,
            StorageError.
        """
        ...

    def command(self, rig: str, run: str, command: Command, lease: str | None) -> None:
        """Pass a command on to an active run.

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

    def revise(self, rig: str, description: Rig, reason: str, lease: str | None) -> None:
        """Go on with another description of what stands on the bench; the bench is opened again.

        Raises:
            LeaseNeededError, NotFoundError, ConflictError, StorageError.
        """
        ...

    def give_consent(self, rig: str, new: ConsentRequest, items: tuple[str, ...], lease: str | None) -> ConsentView:
        """Let these items of a rig's queue begin by themselves.

        Raises:
            LeaseNeededError, NotFoundError.
        """
        ...

    def withdraw_consent(self, rig: str) -> None:
        """Withdraw the consent: nothing starts automatically. Needs no lease.

        Raises:
            NotFoundError.
        """
        ...

    def consent_view(self, rig: str) -> ConsentView | None:
        """What may begin by itself; None: nothing.

        Raises:
            NotFoundError.
        """
        ...


def legal_next_states(state: RunState) -> tuple[RunState, ...]:
    """States that may follow."""
    return tuple(sorted(TRANSITIONS[state]))


def require_action(state: RunState, action: Action) -> None:
    """Reject an action that the table has no step for.

    Raises:
        IllegalTransitionError: with the list of legal states.
    """
    requested = REQUESTED.get(action)
    if requested is not None and (requested not in TRANSITIONS[state] or _begins_run_only(state, action)):
        raise transition_error(state, f"become {requested}")
    if requested is None and state not in AT_WORK:
        raise transition_error(state, action)


def transition_error(state: RunState, what: str) -> IllegalTransitionError:
    """What to raise when a run cannot do `what` in its state."""
    return IllegalTransitionError(
        f"a run that is {state} cannot {what}",
        remedy=f"legal: {', '.join(legal_next_states(state)) or 'none, it has ended'}",
    )


def _begins_run_only(state: RunState, action: Action) -> bool:
    # Armed leads to acquiring too, but by a hit or a burst and not by an operator who resumes.
    return action == "resume" and state != "paused"


@dataclass(frozen=True, slots=True)
class Consent:
    """A lease-holder's word.

    Attributes:
        lease: id of the lease it was given under.
        operator: name of the operator.
        drive: whether tests that move the output may start.
        at_bench: whether impact tests may start.
        items: items of the queue that it covers.
        process: the rig's process when it was given.
        until_s: by the monotonic clock.
    """

    lease: str
    operator: str
    drive: bool
    at_bench: bool
    items: frozenset[str]
    process: int | None
    until_s: float

    @property
    def remaining_s(self) -> float:
        """For so long, if nothing ends it."""
        return self.until_s - time.monotonic()

    @property
    def view(self) -> ConsentView:
        """For whoever asks."""
        items = tuple(sorted(self.items))
        return ConsentView(
            operator=self.operator,
            drive=self.drive,
            at_bench=self.at_bench,
            items=items,
            remaining_s=self.remaining_s,
        )


class RigConsents:
    """Those of all rigs, and the rigs that were stopped in an emergency. From any thread; waits for nothing."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._given: dict[str, Consent] = {}
        self._stopped: set[str] = set()

    def give(self, rig: str, new: ConsentRequest, items: frozenset[str], lease: Lease, process: int | None) -> Consent:
        """Keep one; it takes the place of an earlier one."""
        until_s = time.monotonic() + new.for_s
        consent = Consent(lease.id, lease.operator, new.drive, new.at_bench, items, process, until_s)
        with self._lock:
            self._given[rig] = consent
        return consent

    def get(self, rig: str) -> Consent | None:
        """The one of a rig; None if there is none, or its time is over."""
        with self._lock:
            consent = self._given.get(rig)
        return None if consent is None or consent.remaining_s <= 0 else consent

    def withdraw(self, rig: str) -> None:
        """From now on nothing begins by itself."""
        with self._lock:
            self._given.pop(rig, None)

    def stop(self, rig: str) -> None:
        """The rig is stopped in an emergency."""
        with self._lock:
            self._given.pop(rig, None)
            self._stopped.add(rig)

    def take_stopped(self) -> set[str]:
        """The rigs that were stopped since the last look."""
        with self._lock:
            stopped, self._stopped = self._stopped, set()
        return stopped
