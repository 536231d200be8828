"""A hit at another point than requested does not count, unless the operator says so; a hit at the right one does."""

from pathlib import Path

import numpy as np
import pytest

from modallab.acquisition.monitor.run_states import AcceptBlock, OperatorRequests
from modallab.acquisition.procedures.struck_point.check import AccumulatedFrfs
from modallab.acquisition.process.run import run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Bench
from modallab.core.events import Event
from modallab.core.plan import HitAcceptance, ImpactPlan
from modallab.core.rig import Rig
from modallab.pipelines.known_modes import expected_modes
from modallab.storage import BlockRecord, Store

PLAN = ImpactPlan(points=(3,), hits=2, acceptance=HitAcceptance(max_residual_ratio=0.03))
BENCH = "sim://cantilever?seed=5&bad_hits=0&place_m=0.002&zeta=0.02"


class Misled:
    """A bench whose operator strikes other points than requested: one for each prompt, then what is requested."""

    def __init__(self, bench: Bench, struck: list[int]) -> None:
        self._bench, self._struck = bench, struck

    def __getattr__(self, name: str) -> object:
        return getattr(self._bench, name)

    def prompt_hit(self, point: int) -> None:
        self._bench.prompt_hit(self._struck.pop(0) if self._struck else point)


def struck(
    store: Store,
    rig: Rig,
    points: list[int],
    plan: ImpactPlan = PLAN,
    url: str = BENCH,
    *,
    model: bool = True,
    accepting: bool = False,
) -> tuple[list[BlockRecord], list[Event]]:
    events: list[Event] = []
    requests = OperatorRequests()

    def emit(event: Event) -> None:
        events.append(event)
        if accepting and event.kind == "block" and not event.accepted:
            requests.add(AcceptBlock(event.name))

    bench = Misled(open_bench(url, rig), points)
    expected = expected_modes(rig) if model else None
    with store.begin(plan, rig, bench.info) as recorder:
        run_plan(bench, rig, plan, recorder, emit, requests=requests, expected=expected)
    return list(store.catalogue.blocks(recorder.run)), events


def test_the_first_hit_at_another_point_does_not_count(store: Store, link_rig: Rig) -> None:
    rows, events = struck(store, link_rig, [10])
    assert [(row.note.accepted, row.note.drive_point) for row in rows] == [(False, 3), (True, 3), (True, 3)]
    assert rows[0].note.reason == "this looks like point 10; 3 was requested"
    assert rows[0].note.facts["looks_like_point"] == 10
    assert [e.reason for e in events if e.kind == "hit_rejected"] == [rows[0].note.reason]


@pytest.mark.parametrize("point", [1, 2, 4, 9])
def test_a_later_hit_at_another_point_does_not_count_either(store: Store, link_rig: Rig, point: int) -> None:
    rows, _ = struck(store, link_rig, [3, point])
    assert [row.note.accepted for row in rows] == [True, False, True]
    assert f"looks like point {point}" in rows[1].note.reason


def test_without_a_model_the_frfs_so_far_decide_and_reciprocity_knows_the_next_point(
    store: Store, link_rig: Rig
) -> None:
    plan = PLAN.model_copy(update={"points": (3, 8), "hits": 1})
    rows, _ = struck(store, link_rig, [3, 3], plan, model=False)
    assert [row.note.accepted for row in rows] == [True, False, True]
    assert rows[1].note.reason.startswith("this looks like point 3; 8 was requested")


def test_the_operator_may_accept_it_and_it_is_not_asked_for_again(store: Store, link_rig: Rig) -> None:
    rows, events = struck(store, link_rig, [10, 10], accepting=True)
    assert [row.note.accepted for row in rows] == [True, True]
    (accepted,) = [e for e in events if e.kind == "accepted"]
    assert accepted.name == "impact_p03_1_rejected_1"
    assert rows[0].note.reason == "accepted at the bench"
    assert [e.done for e in events if e.kind == "progress"][-1] == 2


def test_the_check_can_be_turned_off(store: Store, link_rig: Rig) -> None:
    plan = PLAN.model_copy(update={"acceptance": HitAcceptance(max_residual_ratio=0.03, check_point=False)})
    rows, _ = struck(store, link_rig, [10, 10], plan)
    assert [row.note.accepted for row in rows] == [True, True]


@pytest.mark.parametrize(
    "effect",
    ["added_mass,mass=0.1,x=0.5", "polarity,channel=a10,sign=-1", "force_gain,gain=1.3", "swap,channel=a03:a08"],
)
def test_a_bench_that_is_not_as_believed_rejects_no_good_hit(store: Store, link_rig: Rig, effect: str) -> None:
    plan = PLAN.model_copy(update={"points": (10, 6, 3)})
    rows, _ = struck(store, link_rig, [], plan, f"{BENCH}&effect={effect}")
    assert [row.note.reason for row in rows] == [""] * 6


def test_a_rig_without_a_beam_leads_to_expect_nothing(link_rig: Rig) -> None:
    assert expected_modes(link_rig.model_copy(update={"beam": None, "model": "unknown"})) is None


def test_by_reciprocity_a_point_that_has_a_sensor_is_known_before_it_is_struck() -> None:
    rng = np.random.default_rng(3)
    half = rng.standard_normal((4, 4, 50)) + 1j * rng.standard_normal((4, 4, 50))
    frf = half + half.transpose(1, 0, 2)
    known = AccumulatedFrfs(sensed_at=(1, 2, 3, 4), alike=(0, 0, 0, 1))
    known.add_hit("a", 1, frf[:, 0])
    known.add_hit("b", 2, frf[:, 1])
    away = known.distances_to_points(frf[:, 2])
    assert away[3] == pytest.approx(0, abs=1e-12)
    assert min(away[1], away[2]) > 0.7
    # A sensor of another quantity knows nothing of the others' points.
    assert 4 not in away
    known.remove_hit("a")
    assert 1 in known.distances_to_points(frf[:, 2])
    assert known.hits_at(1) == 0


def test_an_oblique_hit_after_good_ones_does_not_count(store: Store, link_rig: Rig, tmp_path: Path) -> None:
    from modallab_simulators.cantilever.hammer import ScriptedHit

    del tmp_path
    bench = open_bench(BENCH, link_rig)
    angles = [0.0, 45.0, 0.0]

    class Oblique(Misled):
        def prompt_hit(self, point: int) -> None:
            strike = ScriptedHit(point, after_s=0.5, oblique_deg=angles.pop(0))
            inner = self._bench
            inner._excitation.strike(strike.hits(inner._now_s, link_rig.x_of(point)))  # type: ignore[attr-defined]
            inner._stream.excitation_changed()  # type: ignore[attr-defined]

    with store.begin(PLAN, link_rig, bench.info) as recorder:
        run_plan(Oblique(bench, []), link_rig, PLAN, recorder, lambda _: None, expected=expected_modes(link_rig))  # type: ignore[arg-type]
    rows = store.catalogue.blocks(recorder.run)
    assert [row.note.accepted for row in rows] == [True, False, True]
    assert "struck obliquely" in rows[1].note.reason
    assert float(rows[1].note.facts["hit_scale"]) == pytest.approx(np.cos(np.pi / 4), rel=0.05)
