"""Which states a run may enter next, and which an operator may ask for: all of it from the one table of transitions."""

from modallab.acquisition.states import TRANSITIONS, IllegalTransitionError
from modallab.schema.events import RunState
from modallab.schema.service.runs import Action

WANTED: dict[Action, RunState] = {"pause": "paused", "resume": "acquiring", "stop": "stopping", "abort": "stopping"}
"""The state an action leads to; dropping and repeating lead to none."""

AT_WORK: frozenset[RunState] = frozenset({"armed", "acquiring", "paused"})
"""States in which a block can be asked for again."""


def legal_after(state: RunState) -> tuple[RunState, ...]:
    """States that may follow."""
    return tuple(sorted(TRANSITIONS[state]))


def require_action(state: RunState, action: Action) -> None:
    """Refuse an action that the table has no step for.

    Raises:
        IllegalTransitionError: with the list of legal states.
    """
    wanted = WANTED.get(action)
    if wanted is not None and (wanted not in TRANSITIONS[state] or _only_begins(state, action)):
        raise refusal(state, f"become {wanted}")
    if wanted is None and state not in AT_WORK:
        raise refusal(state, action)


def refusal(state: RunState, what: str) -> IllegalTransitionError:
    """What to raise when a run cannot do `what` in its state."""
    return IllegalTransitionError(
        f"a run that is {state} cannot {what}",
        remedy=f"legal: {', '.join(legal_after(state)) or 'none, it has ended'}",
    )


def _only_begins(state: RunState, action: Action) -> bool:
    # Armed leads to acquiring too, but by a blow or a burst and not by an operator who resumes.
    return action == "resume" and state != "paused"
