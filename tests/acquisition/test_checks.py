"""A plan that must not be run is rejected before anything moves, with all its problems at once."""

import pytest
from scripted_bench import ScriptedBench, scripted_rig

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.process.run import record_run
from modallab.bench.protocol import BenchInfo
from modallab.core.errors import PlanError
from modallab.core.plan import HitAcceptance, ImpactPlan, SinePlan
from modallab.core.rig import Limits
from modallab.storage import Store

LIMITS = Limits(drive_v=1.0, slew_v_per_s=335.0, force_n=20.0, acceleration_m_s2=50.0, max_burst_s=11.0)
DRIVES = BenchInfo("x://", (), True, False, {})
READS = BenchInfo("x://", (), False, False, {})


def test_a_possible_plan_passes() -> None:
    require_possible(SinePlan(), scripted_rig(LIMITS), DRIVES)
    require_possible(ImpactPlan(points=(1, 2)), scripted_rig(), READS)


@pytest.mark.parametrize(
    ("plan", "problems"),
    [
        (SinePlan(levels_v={"low": 0.4, "high": 1.5}), ["high is 1.5 V; allowed by the rig: 1 V"]),
        (SinePlan(levels_v={"low": 0.5}, frequencies_hz=(10.0, 110.0)), ["slews 345.6 V/s; allowed by the rig: 335"]),
        (SinePlan(settle_s=10.0, levels_v={"low": 0.4}), ["lasts 12.12 s; allowed by the rig: 11 s"]),
        (SinePlan(settle_s=0.5, levels_v={"low": 0.4}), ["settle_s is 0.5; allowed: at least ramp_s = 1"]),
        (SinePlan(frequencies_hz=(10.0, 10.0001), levels_v={"low": 0.4}), ["10.000 Hz occurs twice"]),
        (
            SinePlan(frequencies_hz=(450.0,), levels_v={"x": 2.0}, settle_s=20.0),
            ["450 Hz; allowed: up to 0.4 of the rate", "x is 2 V", "slews", "lasts"],
        ),
        (ImpactPlan(points=(1, 7, 1)), ["7 is not on the rig, which has [1, 2]", "1 occurs twice"]),
        (
            ImpactPlan(points=(1,), trigger_n=20.0, hysteresis_n=25.0, pre_trigger_s=0.9, rate_hz=200.0),
            ["hysteresis_n is 25", "trigger_n is 20", "pre_trigger_s is 0.9", "min_band_hz: 110 Hz"],
        ),
        (ImpactPlan(points=(1,), acceptance=HitAcceptance(min_force_n=500.0)), ["min_force_n is 500"]),
    ],
)
def test_every_problem_is_named_with_its_number(plan: SinePlan | ImpactPlan, problems: list[str]) -> None:
    with pytest.raises(PlanError) as caught:
        require_possible(plan, scripted_rig(LIMITS), DRIVES)
    for problem in problems:
        assert problem in caught.value.what


def test_without_limits_or_output_nothing_is_driven() -> None:
    with pytest.raises(PlanError, match="no limits") as caught:
        require_possible(SinePlan(), scripted_rig(), READS)
    assert "no excitation output" in caught.value.what


def test_a_rejected_plan_touches_the_output_only_to_zero_it(store: Store) -> None:
    bench = ScriptedBench()
    with pytest.raises(PlanError):
        record_run(bench, scripted_rig(), SinePlan(), store, lambda _: None)
    assert set(bench.done) <= {"zero", "stop"}
    (run,) = store.catalogue.runs()
    assert (run.state, "no limits" in run.reason) == ("failed", True)
