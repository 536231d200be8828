"""Whole trials: one without effects is at the floor, and one with what no force predicts shows it for what it is."""

from importlib.resources import files

import pytest

from modallab.core.effect import OneChannel
from modallab.core.effects import Effect
from modallab.core.rig import Rig, Tolerance
from modallab.formats.rig.rig_file import parse_rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.reduce import reduce_blocks, select_lines
from modallab.gap.inference.baseline import baseline
from modallab.gap.model.nuisances import nuisances
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.effect_inspection import inspect_effects
from modallab.gap.report.initial_gap import nuisances_of_campaign, weights_of
from modallab.gap.report.measure import squared_residuals
from modallab.gap.search.fitting import Bench
from modallab_simulators.cantilever.trial import HITS, LAST_ORDER, LEVELS_N, make_trial


@pytest.fixture(scope="module")
def link() -> Rig:
    path = files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


def fitted(rig: Rig, seed: int, *effects: Effect):
    campaign, _ = make_trial(rig, seed, effects)
    prepared = prepare_campaign(campaign)
    data = reduce_blocks(campaign, prepared.blocks, weights_of(prepared))
    free = nuisances(campaign.rig, 450.0)
    bench = Bench(data, select_lines(data, prepared.poles), free, prepared.poles, lambda _: True)
    return prepared, baseline(bench)


AGAIN = pytest.mark.thorough("fits whole trials")


@AGAIN
def test_a_trial_without_effects_is_at_the_floor(link: Rig):
    prepared, fit = fitted(link, 11)
    assert 0.9 < fit.gap < 1.08
    assert not inspect_effects(prepared, fit.problem.twin(fit.u))
    assert not prepared.masked


def test_a_trial_is_a_campaign_of_the_plan(link: Rig):
    campaign, truth = make_trial(link, 3)
    assert truth["effects"] == []
    assert [b.order for b in campaign.blocks] == list(range(LAST_ORDER + 1))
    hits = [b for b in campaign.blocks if b.test == "impact"]
    assert [b.drive_point for b in hits] == [p for p in HITS for _ in range(6)]
    sines = [b for b in campaign.blocks if b.test == "sine"]
    assert {(b.level, b.frequency_hz) for b in sines} == {(level, b.frequency_hz) for level in LEVELS_N for b in sines}
    assert len(sines) == 48
    assert {b.duration_s for b in campaign.blocks} == {1.024}


SHOWN = (
    (Effect(effect="noisy_channel", parameters={"factor": 4.0}, place={"channel": 6}), "factor", 0.06),
    (Effect(effect="mains_hum", parameters={"volts": 0.004, "hz": 60.0}, place={"channel": "all"}), "volts", 0.06),
    (Effect(effect="clipping", parameters={"fraction_of_peak": 0.5}, place={"channel": 10}), "fraction_of_peak", 0.06),
    (Effect(effect="residual_ringing", parameters={"fraction": 0.1}, place={"where": "impact"}), "fraction", 0.35),
    (Effect(effect="floor_vibration", parameters={"rms_acc": 0.05}, place={"where": "base"}), "rms_acc", 0.15),
)


# The fit of a trial takes seconds.
ALWAYS = ("residual_ringing",)


@pytest.mark.parametrize(
    ("effect", "number", "tolerance"),
    [pytest.param(*s, id=s[0].effect, marks=() if s[0].effect in ALWAYS else AGAIN) for s in SHOWN],
)
def test_what_no_force_predicts_is_seen_in_a_trial(link: Rig, effect: Effect, number: str, tolerance: float):
    prepared, fit = fitted(link, 21, effect)
    found = inspect_effects(prepared, fit.problem.twin(fit.u))
    assert [f.effect for f in found] == [effect.effect]
    assert found[0].parameters[number] == pytest.approx(effect.parameters[number], rel=tolerance)
    if isinstance(effect.place, OneChannel):
        assert found[0].place.channel == effect.place.channel


@AGAIN
@pytest.mark.parametrize("rms_acc", [0.04, 0.4])
def test_what_a_shaking_floor_adds_is_as_large_as_stated_in_both_tests(link: Rig, rms_acc: float):
    shaking = Effect(effect="floor_vibration", parameters={"rms_acc": rms_acc}, place={"where": "base"})
    as_built = link.model_copy(update={"tolerance": Tolerance.usual()})
    campaign, _ = make_trial(as_built, 31, (shaking,), "usual")
    prepared = prepare_campaign(campaign)
    # Below the resonances it rises as it falls: it is no noise of the converter that rises to low frequencies.
    assert prepared.rising_v2 < 1e-6
    data = reduce_blocks(prepared.campaign, prepared.blocks, weights_of(prepared))
    bench = Bench(
        data,
        select_lines(data, prepared.poles),
        nuisances_of_campaign(prepared.campaign),
        prepared.poles,
        lambda _: True,
    )
    left = squared_residuals(twin_of(baseline(bench), data), data)
    by_test = left.by(left.tests)
    assert 0.9 < by_test["sine"] < 1.15
    # Resonances are as wide as a line: what they add to hits at one point is seldom its mean.
    assert 0.75 < by_test["impact"] < 1.25
