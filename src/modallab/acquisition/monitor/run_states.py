"""The states of a run, which may follow which, and what its owner may want of it meanwhile."""

from collections.abc import Callable
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from threading import Event as Flag

from modallab.core.documents.runs import RepeatFrequency
from modallab.core.errors import HttpProblem, PlanError
from modallab.core.events import Event, RunState, StateChanged
from modallab.storage import Recorder

Emit = Callable[[Event], None]

TRANSITIONS: dict[RunState, frozenset[RunState]] = {
    "created": frozenset({"arming", "stopping"}),
    "arming": frozenset({"armed", "stopping"}),
    "armed": frozenset({"acquiring", "stopping"}),
    "acquiring": frozenset({"paused", "processing", "stopping"}),
    "paused": frozenset({"acquiring", "stopping"}),
    "processing": frozenset({"done", "stopping"}),
    "stopping": frozenset({"done", "failed", "aborted"}),
    "done": frozenset(),
    "failed": frozenset(),
    "aborted": frozenset(),
}
"""What may follow each state. `stopping` brings the output to zero, so no run ends early but through it;
`stop` leads from it to `done`, an error to `failed`, `abort` to `aborted`."""


class IllegalTransitionError(PlanError):
    """The run cannot change to this state from its present one."""

    code = "illegal-transition"
    http = HttpProblem(409, "The run cannot do this now", "`legal` lists the states that may follow.")


def require_legal(current: RunState, target: RunState) -> None:
    """Reject a step that the table does not have.

    Raises:
        IllegalTransitionError: with the list of legal ones.
    """
    legal = TRANSITIONS[current]
    if target not in legal:
        raise IllegalTransitionError(
            f"a run that is {current} cannot become {target}",
            remedy=f"legal: {', '.join(sorted(legal)) or 'none, it has ended'}",
        )


class RunLifecycle:
    """Where one run stands: each step is checked, committed, then reported."""

    def __init__(self, recorder: Recorder, emit: Emit) -> None:
        self.state: RunState = "created"
        self._recorder = recorder
        self._emit = emit
        emit(StateChanged(run=recorder.run, state="created"))

    def enter_state(self, state: RunState, reason: str = "", *, valid: bool = True) -> None:
        """Go to `state`.

        Raises:
            IllegalTransitionError: not from here.
            StorageError: it could not be committed.
        """
        require_legal(self.state, state)
        self._recorder.enter_state(state, reason, valid=valid)
        self.state = state
        self._emit(StateChanged(run=self._recorder.run, state=state, reason=reason))


@dataclass(frozen=True, slots=True)
class DropBlock:
    """A block no longer counts; in an impact test the hit is asked for again.

    The run knows its blocks by the names of their records, and not by the numbers that an operator's `Drop` carries.
    """

    block: str
    reason: str = "dropped by the operator"


@dataclass(frozen=True, slots=True)
class AcceptBlock:
    """A rejected hit counts all the same; it is not asked for again."""

    block: str
    reason: str = "accepted at the bench"
    operator: str = ""


Request = RepeatFrequency | DropBlock | AcceptBlock


@dataclass(slots=True)
class ExcitationState:
    """Whether a burst may be on, as the test says it: no sign of life then means more than at rest."""

    on: bool = False


class OperatorRequests:
    """Filled by the thread that hears the owner, looked at by the test between blocks or bursts."""

    def __init__(self) -> None:
        self._paused = Flag()
        self._requests: SimpleQueue[Request] = SimpleQueue()

    @property
    def pause_requested(self) -> bool:
        """Whether the test should pause."""
        return self._paused.is_set()

    def pause(self) -> None:
        """From the next boundary on, do nothing but watch."""
        self._paused.set()

    def resume(self) -> None:
        """Go on."""
        self._paused.clear()

    def add(self, request: Request) -> None:
        """Queue a request."""
        self._requests.put(request)

    def take_all(self) -> list[Request]:
        """The requests since the last look, in order."""
        found: list[Request] = []
        while True:
            try:
                found.append(self._requests.get_nowait())
            except Empty:
                return found

    def clear(self) -> None:
        """A new run begins: what was requested of the last one is no request of this one."""
        self.resume()
        self.take_all()
