"""Set-ups at the bench: what is rejected, what is asked for, what is kept."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from modallab.cli.demo import demo_rig
from modallab.core.errors import PlanError
from modallab.core.plan import ImpactPlan, SetUp
from modallab.core.rig import Rig
from modallab.core.setups import SensorMove, rig_in_set_up, setup_problems
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.setups import identify_setups
from modallab.service.campaigns.local_session import record_campaign, record_setups

BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0&effect=sensor_mass,mass_each=0.005"
LEFT, RIGHT = SetUp(name="left"), SetUp(name="right", points={"a01": 3, "a02": 4})
PLAN = ImpactPlan(points=(10,), hits=1, setups=(LEFT, RIGHT))


def three_sensors() -> Rig:
    """The demo's bench with sensors at 10, which stays, 1 and 2."""
    rig = demo_rig()
    channels = [rig.channels[n].model_copy(update={"index": i}) for i, n in enumerate((0, 1, 2, 10))]
    return rig.model_copy(update={"channels": tuple(channels)})


@pytest.mark.parametrize(
    ("setups", "words"),
    [
        ((LEFT, LEFT), "'left' occurs twice"),
        ((SetUp(name="x", points={"a99": 3}),), "no sensor 'a99'"),
        ((SetUp(name="x", points={"a01": 77}),), "a01 at point 77"),
        ((SetUp(name="x", points={"a01": 2}),), "a01 and a02 both at point 2"),
        ((LEFT, SetUp(name="x", points={"a01": 5, "a02": 6, "a10": 7})), "no common point joins left and x"),
    ],
)
def test_set_ups_that_cannot_be_are_rejected(setups: tuple[SetUp, ...], words: str) -> None:
    (problem,) = setup_problems(PLAN.model_copy(update={"setups": setups}), three_sensors())
    assert words in problem


@pytest.mark.thorough("records and identifies two set-ups")
def test_sensors_are_moved_between_the_runs_and_each_is_kept_with_its_rig(tmp_path: Path) -> None:
    asked: list[tuple[str, Sequence[SensorMove]]] = []

    def moved(name: str, moves: Sequence[SensorMove]) -> bool:
        asked.append((name, moves))
        return True

    rig = three_sensors()
    left, right = record_setups(BENCH, rig, [PLAN], tmp_path, lambda _: None, moved)
    assert asked == [("right", (SensorMove("a01", 1, 3), SensorMove("a02", 2, 4)))]
    assert (left.rig, right.rig) == (rig, rig_in_set_up(rig, RIGHT))
    joined = identify_setups((left, right), IdentificationOptions())
    model = joined.result.identified[0].model
    assert model.output_points == (1, 2, 3, 4, 10)
    # 10 g went outwards along the beam: every frequency that moves by much is lower.
    assert joined.compared[1].off
    assert joined.compared[1].shift[1] < 0


def test_whoever_cannot_move_sensors_is_not_left_with_half_a_test(tmp_path: Path) -> None:
    with pytest.raises(PlanError, match="no operator to move sensors"):
        record_campaign(BENCH, three_sensors(), [PLAN], tmp_path, lambda _: None)
