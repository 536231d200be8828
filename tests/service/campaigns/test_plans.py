"""What is left of a plan, and plans no machine could carry out."""

from importlib import resources
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.formats.rig.rig_file import parse_rig
from modallab.service.campaigns.run_start import remaining_plan, require_sensible_numbers
from modallab.service.errors import ConflictError
from modallab.service.rigs.controllers import rig_ids
from modallab.storage.records import BlockNote, BlockRecord

RIG = parse_rig((resources.files("modallab.cli") / "link_rig.yaml").read_text(encoding="utf-8"), "link")


def block(n: int, *, point: int | None = None, level: str | None = None, hz: float | None = None, good=True):
    note = BlockNote(f"b{n}", "impact", 0, drive_point=point, level=level, frequency_hz=hz, accepted=good)
    return BlockRecord("run", n, 0, 1, 0, 0.0, "", note)


def test_points_without_all_their_hits_are_struck_anew() -> None:
    plan = ImpactPlan(points=(10, 6, 3), hits=2)
    blocks = [block(0, point=10), block(1, point=10), block(2, point=6), block(3, point=6, good=False)]
    assert remaining_plan(plan, blocks) == plan.model_copy(update={"points": (6, 3)})


@given(st.sets(st.tuples(st.sampled_from(["low", "high"]), st.sampled_from([10.0, 20.0, 30.0]))))
def test_every_missing_frequency_is_left_and_nothing_is_if_none_is(have: set[tuple[str, float]]) -> None:
    plan = SinePlan(frequencies_hz=(10.0, 20.0, 30.0), levels_v={"low": 0.2, "high": 0.4})
    blocks = [block(n, level=level, hz=hz) for n, (level, hz) in enumerate(sorted(have))]
    planned = {(level, hz) for level in plan.levels_v for hz in plan.frequencies_hz}
    if have == planned:
        with pytest.raises(ConflictError):
            remaining_plan(plan, blocks)
        return
    left = remaining_plan(plan, blocks)
    assert isinstance(left, SinePlan)
    assert planned - have <= {(level, hz) for level in left.levels_v for hz in left.frequencies_hz}


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("block_s", 1e300),
        ("block_s", inf),
        ("rate_hz", 1e12),
        ("hit_timeout_s", inf),
        ("block_s", 1e-9),
        ("hits", 10**9),
    ],
)
def test_a_plan_no_machine_could_carry_out_is_rejected(field: str, value: float) -> None:
    plan = ImpactPlan.model_validate({"points": (10,), field: value})
    with pytest.raises(PlanError):
        require_sensible_numbers(plan, RIG)


def test_the_plans_of_the_paper_are_reasonable() -> None:
    require_sensible_numbers(ImpactPlan(points=(10,)), RIG)
    require_sensible_numbers(SinePlan(), RIG)


def test_ids_of_rigs_are_made_of_their_names_and_differ() -> None:
    made = rig_ids(["The Link!", "the link", "the  link", "Ärm", "???"])
    assert made == ("the-link", "the-link--2", "the-link--3", "rm", "rig")
