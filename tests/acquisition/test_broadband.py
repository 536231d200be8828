"""The broadband test: waves of known peak from 0 V to 0 V, blocks without a gap, a model from each signal."""

from math import sqrt

import numpy as np
import pytest

from modallab.acquisition.procedures.broadband_wave import blocks_per_wave, make_wave, peak_v, slew_v_per_s, wave_layout
from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.bench.protocol import BenchInfo
from modallab.core.block import Block, Campaign
from modallab.core.errors import PlanError, SafetyError
from modallab.core.events import Event, OperatorNotice
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.service.campaigns.live_frf import LiveFrfs
from modallab.storage import Store

URL = "sim://cantilever?seed=1"
INFO = BenchInfo(URL, (), can_drive=True, real_time=False, facts={})
FIRST_HZ = (4.75495, 30.59341, 87.14636, 173.03204)
FIRST_DAMPING = (0.0061389, 0.0060162, 0.0059400, 0.0049392)
"""What the bench of this seed was built with."""


def plan_of(signal: Broadband, **fields: object) -> BroadbandPlan:
    return BroadbandPlan.model_validate({"signal": signal, "levels_v": {"low": 0.2}, "blocks": 20, **fields})


@pytest.mark.parametrize("signal", BROADBAND)
def test_a_wave_begins_and_ends_at_zero_has_its_level_and_keeps_to_its_band(signal: Broadband) -> None:
    plan = plan_of(signal, burst_share=0.5)
    layout = wave_layout(plan, 4, plan.block_s)
    wave = make_wave(plan, "low", 0, layout)
    assert wave.samples[0] == wave.samples[-1] == 0.0
    assert wave.duration_s == pytest.approx(layout.end_s, abs=2 / wave.rate_hz)
    first = round(layout.lead_s * wave.rate_hz)
    period = round(plan.block_s * wave.rate_hz)
    block = wave.samples[first : first + period]
    on = block[block != 0] if signal == "burst-random" else block
    assert sqrt(float(np.mean(on**2))) == pytest.approx(0.2, rel=0.15)
    power = np.abs(np.fft.rfft(block * np.hanning(period))) ** 2
    hz = np.arange(power.size) / plan.block_s
    assert power[(hz > 0.5 * plan.band_hz[0]) & (hz < 1.3 * plan.band_hz[1])].sum() > 0.99 * power.sum()


@pytest.mark.parametrize("signal", ["pseudo-random", "chirp"])
def test_a_periodic_wave_repeats_with_every_block_and_joins_itself(signal: Broadband) -> None:
    plan = plan_of(signal)
    layout = wave_layout(plan, 3, plan.block_s)
    wave = make_wave(plan, "low", 0, layout)
    period = round(plan.block_s * wave.rate_hz)
    first = round(layout.lead_s * wave.rate_hz)
    one, two = wave.samples[first : first + period], wave.samples[first + period : first + 2 * period]
    np.testing.assert_allclose(one, two, atol=1e-12)
    steepest = np.abs(np.diff(wave.samples)).max()
    assert abs(two[0] - one[-1]) <= steepest * 1.001


def test_detection_lines_are_all_even_ones_and_each_odd_one_in_one_of_four_waves() -> None:
    plan = plan_of("pseudo-random", detection_lines=True, blocks_per_wave=2, blocks=8, band_hz=(2.0, 100.0))
    layout = wave_layout(plan, 2, plan.block_s)
    held = []
    for number in range(4):
        wave = make_wave(plan, "low", number, layout)
        first, period = round(layout.lead_s * wave.rate_hz), round(plan.block_s * wave.rate_hz)
        power = np.abs(np.fft.rfft(wave.samples[first : first + period]))[3:103]
        held.append(power > 1e-6 * power.max())
    times = np.sum(held, axis=0)
    assert set(times[::2]) == {3}
    assert not times[1::2].any()


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"signal": "chirp"}, "leaves no lines out"),
        ({"blocks_per_wave": None}, "8 blocks, as many as fit in a wave"),
        ({"blocks_per_wave": 3}, "8 blocks, 3 in a wave"),
    ],
)
def test_detection_lines_ask_for_four_waves_of_two_periods(
    link_rig: Rig, fields: dict[str, object], words: str
) -> None:
    plan = plan_of("pseudo-random", detection_lines=True, blocks_per_wave=2, blocks=8)
    require_possible(plan, link_rig, INFO)
    with pytest.raises(PlanError, match=words):
        require_possible(BroadbandPlan.model_validate(plan.model_dump() | fields), link_rig, INFO)


def test_waves_of_one_seed_are_the_same_and_each_wave_has_its_own_phases() -> None:
    plan = plan_of("random")
    layout = wave_layout(plan, 2, plan.block_s)
    np.testing.assert_array_equal(make_wave(plan, "low", 0, layout).samples, make_wave(plan, "low", 0, layout).samples)
    assert not np.array_equal(make_wave(plan, "low", 0, layout).samples, make_wave(plan, "low", 1, layout).samples)


def test_a_peak_a_slew_or_a_length_beyond_the_rigs_limits_is_rejected_with_its_number(link_rig: Rig) -> None:
    with pytest.raises(PlanError, match=r"levels_v: low has a peak of .* V; allowed by the rig: 5 V"):
        require_possible(plan_of("random", levels_v={"low": 3.0}), link_rig, INFO)
    assert link_rig.limits is not None
    slow = link_rig.model_copy(update={"limits": link_rig.limits.model_copy(update={"slew_v_per_s": 100.0})})
    with pytest.raises(PlanError, match="slews"):
        require_possible(plan_of("chirp"), slow, INFO)
    short = link_rig.model_copy(update={"limits": link_rig.limits.model_copy(update={"max_burst_s": 9.0})})
    with pytest.raises(PlanError, match="a wave of one block lasts"):
        require_possible(plan_of("chirp"), short, INFO)
    with pytest.raises(PlanError, match="band_hz"):
        require_possible(plan_of("chirp", band_hz=(2.0, 900.0)), link_rig, INFO)
    require_possible(plan_of("pseudo-random"), link_rig, INFO)


def test_every_wave_played_is_within_what_the_check_has_seen(link_rig: Rig) -> None:
    plan = plan_of("random")
    assert link_rig.limits is not None
    layout = wave_layout(plan, blocks_per_wave(plan, link_rig.limits.max_burst_s), plan.block_s)
    wave = make_wave(plan, "low", 0, layout)
    assert peak_v(wave) < link_rig.limits.drive_v
    assert slew_v_per_s(wave) < link_rig.limits.slew_v_per_s
    assert wave.duration_s <= link_rig.limits.max_burst_s


def blocks_of(store: Store, rig: Rig, plan: BroadbandPlan) -> tuple[tuple[Block, ...], list[Event], str]:
    events: list[Event] = []
    bench = open_bench(URL, rig)
    run = record_run(bench, rig, plan, store, events.append)
    bench.close()
    return tuple(store.blocks(run)), events, run


def test_blocks_follow_each_other_without_a_gap_and_say_what_they_are(store: Store, link_rig: Rig) -> None:
    plan = plan_of("burst-random", blocks=3, levels_v={"low": 0.2, "high": 0.4})
    blocks, events, run = blocks_of(store, link_rig, plan)
    assert [b.level for b in blocks] == ["low"] * 3 + ["high"] * 3
    assert {b.test for b in blocks} == {"burst-random"}
    low = [b.first_sample for b in blocks[:3]]
    assert np.diff(low).tolist() == [2048, 2048]
    facts = store.catalogue.blocks(run)[0].note.facts
    assert facts["drive_rms_v"] == 0.2
    assert 0.2 < float(facts["drive_peak_v"]) < 1.5
    notice = next(e for e in events if isinstance(e, OperatorNotice))
    assert "longest burst" in notice.what
    frf = LiveFrfs(store).frf(run)
    assert frf.coherence is not None
    assert frf.averages == (3,)


def test_where_a_wave_may_not_hold_all_blocks_another_one_follows(store: Store, link_rig: Rig) -> None:
    assert link_rig.limits is not None
    rig = link_rig.model_copy(update={"limits": link_rig.limits.model_copy(update={"max_burst_s": 11.0})})
    blocks, _, _ = blocks_of(store, rig, plan_of("pseudo-random", blocks=5))
    starts = np.diff([b.first_sample for b in blocks])
    assert len(blocks) == 5
    assert sorted(set(starts.tolist()))[0] == 2048
    assert starts.max() > 2048


@pytest.mark.thorough("records and identifies with every signal")
@pytest.mark.parametrize("signal", BROADBAND)
def test_each_signal_gives_the_model_the_bench_was_built_with(store: Store, link_rig: Rig, signal: Broadband) -> None:
    blocks, _, _ = blocks_of(store, link_rig, plan_of(signal))
    result = identify_campaign(Campaign(link_rig, blocks), IdentificationOptions())
    model = result.identified[0].model
    assert model.test == signal
    np.testing.assert_allclose(model.frequency_hz[:4], FIRST_HZ, rtol=3e-4)
    # The first mode still fades when the blocks begin: its decay is part of the periodic signals' blocks.
    np.testing.assert_allclose(model.damping_ratio[1:4], FIRST_DAMPING[1:], rtol=0.02)
    np.testing.assert_allclose(model.damping_ratio[0], FIRST_DAMPING[0], rtol=0.1)


def test_a_linear_bench_answers_nothing_at_the_lines_that_its_drive_leaves_out(store: Store, link_rig: Rig) -> None:
    """With the free decays left in the blocks it seems to: by 0.9 %."""
    plan = plan_of("pseudo-random", detection_lines=True, blocks_per_wave=2, blocks=8, band_hz=(2.0, 110.0))
    blocks, _, _ = blocks_of(store, link_rig, plan)
    assert len({b.name.rsplit("_", 1)[0] for b in blocks}) == 4
    assessment = identify_campaign(Campaign(link_rig, blocks), IdentificationOptions()).identified[0].assessment
    assert assessment is not None
    verdict = next(v for v in assessment.verdicts if v.assumption == "linearity")
    assert verdict.value < 2e-3
    assert "lines that the drive leaves out" in verdict.words


def test_beyond_a_limit_the_run_ends_at_zero_and_keeps_what_tripped(store: Store, link_rig: Rig) -> None:
    assert link_rig.limits is not None
    rig = link_rig.model_copy(update={"limits": link_rig.limits.model_copy(update={"force_n": 0.5})})
    bench = open_bench(URL, rig)
    with pytest.raises(SafetyError, match="beyond the abort limit"):
        record_run(
            bench, rig, plan_of("random", blocks=2, band_hz=(2.0, 100.0), levels_v={"low": 1.0}), store, lambda _: None
        )
    rows = store.catalogue.blocks(store.catalogue.runs()[-1].id)
    assert [(r.note.accepted, r.note.name.endswith("_tripped")) for r in rows] == [(False, True)]
