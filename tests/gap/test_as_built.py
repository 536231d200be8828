"""A bench on which a little of everything is wrong: what its rig file allows is no gap, what is beyond it is named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.progress import report_progress_to
from modallab.core.rig import Rig, Tolerance
from modallab.gap.diagnosis import diagnose
from modallab.gap.model.tolerances import apply_tolerances, by_tolerance, deviations, with_tolerances
from modallab.gap.report.calibrated import diagnosed_twin
from modallab.gap.words.verdicts import gap_in_percent, verdict_sentence
from modallab.reporting.gap_report import render
from modallab.twin.bench import Twin

Make = Callable[..., Campaign]
POSITIVE = {"damper_n_s_per_m", "sensor_mass_kg", "shaker_mass_kg", "stinger_rotation", "clamp_compliance"}
HITS = [(0.6, 2), (1.0, 2), (0.3, 2)]


def as_built(rig: Rig, seed: int = 3, care: float = 0.8) -> Callable[[Twin], Twin]:
    """The bench with every number of its assembly so many deviations or so off."""
    rng = np.random.default_rng(seed)
    # The campaign's records do not say when they were made: nothing drifts.
    fixed = {"sensitivity", "stiffness_drift"}
    numbers = [(d, float(rng.normal(0, care))) for d in deviations(rig, HITS) if d.tolerance not in fixed]
    # A damper or a mass that is less than none is on no bench; several dampers below zero leave a mode undamped.
    numbers = [(d, abs(moved) if d.tolerance in POSITIVE else moved) for d, moved in numbers]
    gains = {c.index: float(np.exp(0.01 * rng.normal())) for c in rig.responses}

    def alter(twin: Twin) -> Twin:
        off = apply_tolerances(twin, rig, by_tolerance((d, d.value(moved)) for d, moved in numbers))
        chain = replace(off.chain, gain={c: g * twin.chain.gain.get(c, 1.0) for c, g in gains.items()})
        # What effects have moved stays where they put it.
        return replace(off, chain=chain)

    return alter


@pytest.fixture(scope="module")
def rough(rig: Rig) -> Rig:
    return rig.model_copy(update={"tolerance": Tolerance.usual()})


@pytest.fixture(scope="module")
def campaign(make: Make, rough: Rig) -> Campaign:
    return replace(make(alter=as_built(rough)), rig=rough)


@pytest.fixture(scope="module")
def steps() -> list[tuple[float, str]]:
    return []


@pytest.fixture(scope="module")
def sound(campaign: Campaign, steps: list[tuple[float, str]]) -> Diagnosis:
    with report_progress_to(lambda share, words: steps.append((share, words))):
        return diagnose(campaign)


def only(*names: str) -> Callable[[str], bool]:
    return lambda name: name in names


def test_a_bench_within_its_tolerances_has_no_gap(sound: Diagnosis) -> None:
    assert sound.verdict == "no_gap"
    assert sound.effects == []
    assert sound.gap.after == pytest.approx(1.0, abs=0.08)
    assert "tolerances" in verdict_sentence(sound)


def test_hits_that_no_fit_has_seen_are_given_their_own_place(sound: Diagnosis) -> None:
    assert sound.shrink.held_out
    assert sound.shrink.after == pytest.approx(1.0, abs=0.12)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_what_no_effect_explains_and_moves_nothing_that_matters_is_a_note(make: Make, rough: Rig) -> None:
    # Of more than the tolerances no single effect is the cause, and the twin still predicts what nobody has shown it.
    careless = replace(make(alter=as_built(rough, care=1.75)), rig=rough)
    found = diagnose(careless, allowed=only())
    assert found.verdict == "no_gap"
    assert any("No effect explains" in note for note in found.notes)
    assert any("all deviations together are improbable" in note for note in found.notes)


def test_the_budget_is_whole_and_the_noise_is_small(sound: Diagnosis) -> None:
    assert sound.budget is not None
    assert sum(r.share for r in sound.budget.rows) == pytest.approx(1.0, abs=1e-6)
    assert {r.kind for r in sound.budget.rows} == {"tolerance", "model", "noise"}
    left = {r.kind: r.share for r in sound.budget.rows if r.kind != "tolerance"}
    assert left["noise"] < 0.01
    assert abs(left["model"]) < 0.01
    assert all("standard deviations" in line for line in sound.budget.calibrate)


def test_the_budget_says_where_each_part_lies(sound: Diagnosis) -> None:
    assert sound.budget is not None
    for row in sound.budget.rows:
        assert set(row.by) == {"test", "channel", "band", "mode"}
        for parts in row.by.values():
            assert sum(parts.values()) == pytest.approx(row.share, abs=1e-9)
    # A sensor that stands elsewhere is no other channel's matter.
    moved = next(r for r in sound.budget.rows if r.name == "position_m")
    elsewhere = [share for name, share in moved.by["channel"].items() if name != moved.place]
    assert max(map(abs, elsewhere)) < 1e-9


def test_a_diagnosis_says_what_it_is_at(sound: Diagnosis, steps: list[tuple[float, str]]) -> None:
    shares = [share for share, _ in steps]
    assert shares == sorted(shares)
    assert 0 == shares[0] < shares[-1] < 1
    assert any("without any effect" in words for _, words in steps)


def test_the_gap_is_stated_in_percent_too(sound: Diagnosis) -> None:
    nominal, after = sound.gap.share_nominal, sound.gap.share_after
    assert nominal is not None
    assert after is not None
    assert nominal.at_resonance is not None
    assert after.at_resonance is not None
    assert nominal.at_resonance > 0.05
    assert after.at_resonance < 0.01
    assert "%" in gap_in_percent(sound.gap)


def test_what_is_left_beyond_noise_is_stated(sound: Diagnosis) -> None:
    left = sound.gap.discrepancy
    assert left is not None
    assert left.median < 0.001
    assert left.worst < 0.01
    assert "Beyond noise" in gap_in_percent(sound.gap)


def test_the_diagnosed_twin_is_the_one_that_was_fitted(sound: Diagnosis, campaign: Campaign) -> None:
    read = Diagnosis.model_validate_json(sound.model_dump_json())
    twin = diagnosed_twin(read, campaign.rig, of_others=False)
    assert {d.tolerance for d in read.twin.departures} >= {"position_m", "sensor_mass_kg", "hit_position_m"}
    assert dict(twin.hit_offsets_m).keys() == {0.3, 0.6, 1.0}
    assert diagnosed_twin(read, campaign.rig).hit_offsets_m == ()


def test_the_report_shows_curves_and_budget(sound: Diagnosis, campaign: Campaign) -> None:
    page = render(sound, campaign)
    for shown in (
        "simulated from the rig file",
        "with the effects found",
        "what is left",
        "Budget of the gap",
        "FRF of the hits",
    ):
        assert shown in page


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_gain_beyond_its_tolerance_is_named_as_large_as_it_is(make: Make, rough: Rig) -> None:
    wrong = Effect(effect="gain_error", parameters={"gain": 1.1}, place={"channel": 7})
    gained = replace(make(wrong, alter=_gained(rough)), rig=rough)
    found = diagnose(gained, allowed=only("gain_error", "position_error", "force_gain"))
    assert [f.effect for f in found.effects] == ["gain_error"]
    low, high = found.effects[0].interval["gain"]
    assert low < 1.1 < high
    assert found.effects[0].parameters["gain"] == pytest.approx(1.1, rel=0.01)


def _gained(rig: Rig) -> Callable[[Twin], Twin]:
    """Off as the others, but for the sensitivity of the channel in question."""
    alter = as_built(rig)

    def altered(twin: Twin) -> Twin:
        off = alter(twin)
        return replace(off, chain=replace(off.chain, gain={**off.chain.gain, 7: twin.chain.gain.get(7, 1.0)}))

    return altered


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_soft_clamp_is_one_number_whatever_its_tolerance(make: Make, rough: Rig) -> None:
    assert rough.beam is not None
    stiffness = 30 * rough.beam.bending_stiffness_n_m2 / rough.beam.length_m
    soft = Effect(effect="clamp_rotation", parameters={"k_rot": stiffness}, place={"x": 0.0})
    alter = as_built(rough)

    def with_one_root(twin: Twin) -> Twin:
        # The total is what counts: the bench has no other spring at its root.
        off = alter(twin)
        return replace(off, structure=replace(off.structure, root_rotation=1 / 30))

    found = diagnose(replace(make(soft, alter=with_one_root), rig=rough), allowed=only("clamp_rotation", "added_mass"))
    assert [f.effect for f in found.effects] == ["clamp_rotation"]
    assert found.effects[0].parameters["k_rot"] == pytest.approx(stiffness, rel=0.03)
    assert all(d.tolerance != "clamp_compliance" for d in found.twin.departures)


def test_a_rig_file_that_states_no_tolerances_gets_usual_ones(rig: Rig) -> None:
    bare = rig.model_copy(update={"tolerance": Tolerance(response=0.05)})
    assert not bare.tolerance.stated
    assert with_tolerances(bare).tolerance.hit_position_m == Tolerance.usual().hit_position_m
    assert with_tolerances(bare).tolerance.response == 0.05
    assert with_tolerances(rig) is rig
