"""The states of a run: which may follow which, and entering one."""

from collections.abc import Callable

from modallab.core.errors import Http, PlanError
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
    """The run may not enter this state from where it is."""

    code = "illegal-transition"
    http = Http(409, "The run cannot do this now", "`legal` lists the states that may follow.")


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


class Lifecycle:
    """Where one run stands: each step is checked, committed, then reported."""

    def __init__(self, recorder: Recorder, emit: Emit) -> None:
        self.state: RunState = "created"
        self._recorder = recorder
        self._emit = emit
        emit(StateChanged(run=recorder.run, state="created"))

    def enter(self, state: RunState, reason: str = "", *, valid: bool = True) -> None:
        """Go to `state`.

        Raises:
            IllegalTransitionError: not from here.
            StorageError: it could not be committed.
        """
        require_legal(self.state, state)
        self._recorder.enter(state, reason, valid=valid)
        self.state = state
        self._emit(StateChanged(run=self._recorder.run, state=state, reason=reason))
