"""Which states a run may enter next, and which an operator may ask for: all of it from the one table of transitions."""

from modallab.acquisition.monitor.run_states import TRANSITIONS, IllegalTransitionError
from modallab.core.documents.runs import Action
from modallab.core.events import RunState

REQUESTED: dict[Action, RunState] = {"pause": "paused", "resume": "acquiring", "stop": "stopping", "abort": "stopping"}
"""The state an action leads to; dropping and repeating lead to none."""

AT_WORK: frozenset[RunState] = frozenset({"armed", "acquiring", "paused"})
"""States in which a block can be asked for again."""


def legal_after(state: RunState) -> tuple[RunState, ...]:
    """States that may follow."""
    return tuple(sorted(TRANSITIONS[state]))


def require_action(state: RunState, action: Action) -> None:
    """Reject an action that the table has no step for.

    Raises:
        IllegalTransitionError: with the list of legal states.
    """
    requested = REQUESTED.get(action)
    if requested is not None and (requested not in TRANSITIONS[state] or _only_begins(state, action)):
        raise rejection(state, f"become {requested}")
    if requested is None and state not in AT_WORK:
        raise rejection(state, action)


def rejection(state: RunState, what: str) -> IllegalTransitionError:
    """What to raise when a run cannot do `what` in its state."""
    return IllegalTransitionError(
        f"a run that is {state} cannot {what}",
        remedy=f"legal: {', '.join(legal_after(state)) or 'none, it has ended'}",
    )


def _only_begins(state: RunState, action: Action) -> bool:
    # Armed leads to acquiring too, but by a hit or a burst and not by an operator who resumes.
    return action == "resume" and state != "paused"
