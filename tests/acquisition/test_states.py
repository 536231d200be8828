"""The table of transitions: what a run may do next, and what it may not."""

from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.acquisition.monitor.run_states import TRANSITIONS, IllegalTransitionError, RunLifecycle, require_legal
from modallab.core.events import RunState, StateChanged
from modallab.storage.records import ENDED

STATES = get_args(RunState)
states = st.sampled_from(STATES)


class CampaignRepository:
    """Stands where the recorder does: notes what was committed."""

    run = "r"

    def __init__(self) -> None:
        self.committed: list[str] = ["created"]

    def enter_state(self, state: RunState, reason: str = "", *, valid: bool = True) -> None:
        self.committed.append(state)


def test_the_table_speaks_of_every_state_once() -> None:
    assert set(TRANSITIONS) == set(STATES)


@given(states, states)
def test_a_step_is_legal_exactly_if_the_table_has_it(current: RunState, target: RunState) -> None:
    if target in TRANSITIONS[current]:
        require_legal(current, target)
    else:
        with pytest.raises(IllegalTransitionError) as caught:
            require_legal(current, target)
        assert all(state in caught.value.remedy for state in TRANSITIONS[current])


@given(st.lists(states, max_size=30))
def test_every_walk_is_reported_as_committed_and_ends_through_stopping_or_processing(walk: list[RunState]) -> None:
    repository, reported = CampaignRepository(), []
    life = RunLifecycle(repository, reported.append)
    for state in walk:
        try:
            life.enter_state(state)
        except IllegalTransitionError:
            continue
    assert [event.state for event in reported if isinstance(event, StateChanged)] == repository.committed
    if life.state in ENDED:
        assert repository.committed[-2] in ("stopping", "processing")
    if life.state in ("failed", "aborted"):
        assert repository.committed[-2] == "stopping"


def test_every_active_state_may_stop_and_no_ended_one_may_go_on() -> None:
    for state, following in TRANSITIONS.items():
        if state in ENDED:
            assert not following
        else:
            assert "stopping" in following or state == "stopping"
