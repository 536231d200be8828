"""Force control between bursts, and the order of the sweeps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scripted_bench import ScriptedBench, scripted_rig

from modallab.acquisition.procedures.burst import HEADROOM, MAX_GROWTH, MeasuredBurst, SineDrive
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Burst
from modallab.core.errors import PlanError
from modallab.core.plan import ForceControl, SinePlan
from modallab.core.rig import Limits, Rig
from modallab.storage import Store

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
RIG = scripted_rig(LIMITS)


def sine(**fields: object) -> SinePlan:
    plain = {"frequencies_hz": (27.34375, 60.0), "levels_v": {"low": 0.5}, "settle_s": 1.5, "wait_s": 1.0}
    return SinePlan.model_validate(plain | fields)


class Dropping(ScriptedBench):
    """At 60 Hz the shaker's force drops to a fifth, as on a resonance."""

    def play(self, burst: Burst) -> int:
        self.gain = 20.0 if burst.frequency_hz > 50 else 100.0
        return super().play(burst)


def forces(store: Store, run: str) -> dict[str, float]:
    """Amplitude of the force of each block that counts, read off its samples."""
    return {b.name: float(np.sqrt(2) * b.samples[0].std() * b.scale[0]) for b in store.blocks(run)}


def test_a_constant_drive_takes_one_burst_a_frequency_whatever_the_force(store: Store) -> None:
    bench = Dropping()
    run = record_run(bench, RIG, sine(), store, lambda _: None)
    assert bench.done.count("play") == 2
    assert [r.note.facts["drive_v"] for r in store.catalogue.blocks(run)] == [0.5, 0.5]
    found = [float(r.note.facts["force_n"]) for r in store.catalogue.blocks(run)]
    assert found == pytest.approx([0.5, 0.1], rel=0.02)


def test_the_force_is_brought_to_what_is_requested_between_bursts(store: Store) -> None:
    bench = Dropping()
    plan = sine(force=ForceControl(levels_n={"low": 0.8}))
    run = record_run(bench, RIG, plan, store, lambda _: None)
    assert list(forces(store, run).values()) == pytest.approx([0.8, 0.8], rel=0.05)
    # Each burst has one amplitude from its start to its end.
    assert len({(s, b.amplitude_v) for s, b in bench.bursts}) == len(bench.bursts)
    rows = store.catalogue.blocks(run)
    assert [r.note.name for r in rows if r.note.accepted] == ["sine_low_027.344", "sine_low_060.000"]
    first = rows[0]
    assert first.note.name == "sine_low_027.344_rejected_1"
    assert "force 0.4982 N" in first.note.reason
    assert "0.8 N +- 5 % was requested" in first.note.reason
    # The next frequency begins with no more than the plan's drive, though more was needed here.
    assert next(r.note.facts["drive_v"] for r in rows if r.note.frequency_hz == 60.0) == 0.5


def test_after_so_many_bursts_the_last_one_counts_and_is_flagged(store: Store) -> None:
    plan = sine(frequencies_hz=(60.0,), force=ForceControl(levels_n={"low": 5.0}, max_bursts=2))
    run = record_run(Dropping(), RIG, plan, store, lambda _: None)
    first, last = store.catalogue.blocks(run)
    assert not first.note.accepted
    assert last.note.accepted
    # 0.1 N with 0.5 V, then three times as much and no more at once.
    assert last.note.facts["drive_v"] == pytest.approx(MAX_GROWTH * 0.5)
    assert "force 0.2998 N" in last.note.reason


def test_at_the_rigs_limit_there_is_no_other_drive_to_try(store: Store) -> None:
    limits = LIMITS.model_copy(update={"drive_v": 0.5})
    bench = Dropping()
    plan = sine(frequencies_hz=(60.0,), force=ForceControl(levels_n={"low": 5.0}))
    run = record_run(bench, scripted_rig(limits), plan, store, lambda _: None)
    assert bench.done.count("play") == 1
    (only,) = store.catalogue.blocks(run)
    assert only.note.accepted
    assert "was requested" in only.note.reason


@given(st.floats(0.01, 5.0), st.floats(1e-3, 100.0), st.floats(0.0, 1.0), st.floats(1.0, 400.0), st.floats(0.1, 40.0))
def test_no_correction_leads_beyond_a_limit(
    volts: float, force: float, used: float, hz: float, requested: float
) -> None:
    drive = SineDrive(sine(force=ForceControl(levels_n={"low": requested})), LIMITS)
    found = drive.next_v("low", hz, MeasuredBurst(volts, force, used))
    if found is None:
        return
    assert found <= LIMITS.drive_v * (1 + 1e-12)
    assert 2 * np.pi * hz * found <= LIMITS.slew_v_per_s * (1 + 1e-12)
    assert found <= MAX_GROWTH * volts * (1 + 1e-12)
    if found > volts:
        assert used * found / volts <= HEADROOM * (1 + 1e-9)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        (ForceControl(levels_n={"loud": 1.0}), "levels_n: loud; allowed: the levels of levels_v"),
        (ForceControl(levels_n={"low": 45.0}), "low is 45 N; allowed: up to 0.8 of the rig's limit, 40 N"),
    ],
)
def test_a_force_the_rig_does_not_allow_is_rejected(store: Store, force: ForceControl, said: str) -> None:
    with pytest.raises(PlanError, match=said):
        record_run(ScriptedBench(), RIG, sine(force=force), store, lambda _: None)


def test_on_the_beam_the_force_is_reached_and_what_was_right_stays_right(store: Store, link_rig: Rig) -> None:
    bench = open_bench("sim://cantilever?seed=4&zeta=0.02", link_rig)
    plan = SinePlan(
        frequencies_hz=(20 / 1.024, 31 / 1.024), settle_s=3.0, wait_s=2.0, force=ForceControl(levels_n={"low": 0.2})
    )
    run = record_run(bench, link_rig, plan, store, lambda _: None)
    found = [float(r.note.facts["force_n"]) for r in store.catalogue.blocks(run) if r.note.accepted]
    assert found == pytest.approx([0.2, 0.2], rel=0.05)
    # The bench's shaker gives so many N per V at every frequency, so what was right once is right again.
    assert [r.note.accepted for r in store.catalogue.blocks(run)] == [False, True, True]


@pytest.mark.parametrize(
    ("sweep", "order"),
    [
        ("given", ["60.000", "27.344"]),
        ("up", ["27.344", "60.000"]),
        ("down", ["60.000", "27.344"]),
        ("up-down", ["27.344", "60.000", "60.000_down", "27.344_down"]),
    ],
)
def test_frequencies_are_swept_in_the_order_that_is_asked_for(store: Store, sweep: str, order: list[str]) -> None:
    plan = sine(frequencies_hz=(60.0, 27.34375), sweep=sweep)
    run = record_run(ScriptedBench(), RIG, plan, store, lambda _: None)
    assert [b.name for b in store.blocks(run)] == [f"sine_low_0{name}" for name in order]
