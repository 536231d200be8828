"""The page of a diagnosis: words and numbers as a person reads them."""

import re

import pytest
from made_diagnosis import made_diagnosis
from twin_campaign import built, link

from modallab.core.block import Campaign
from modallab.core.budget import Budget, BudgetRow
from modallab.core.diagnosis import CandidateSet, Diagnosis, ResponseShare
from modallab.core.effect import AlongBeam
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.words.effects import place_of
from modallab.gap.words.verdicts import verdict_sentence
from modallab.reporting.figures.gap_curves import gap_curves
from modallab.reporting.gap_candidates import typeset_sentence
from modallab.reporting.gap_report import render
from modallab.reporting.markup import Bar, scaled_bars

MASS = Effect(effect="added_mass", parameters={"mass": 0.049321648}, place={"x": 0.8})
SWAP = Effect(effect="swap", place={"channel": (3, 7)})


@pytest.fixture(scope="module")
def rig() -> Rig:
    return link()


@pytest.fixture(scope="module")
def campaign(rig: Rig) -> Campaign:
    return built(rig)


@pytest.fixture(scope="module")
def diagnosis(rig: Rig, campaign: Campaign) -> Diagnosis:
    """A mass of 49.3 g, found at 0.8 of the length, with all that a page can show."""
    plain = made_diagnosis(rig, MASS, probability=0.995)
    assert rig.beam is not None
    (found,) = plain.effects
    found = found.model_copy(
        update={
            "place": AlongBeam(x=0.8, x_m=0.8 * rig.beam.length_m),
            "interval": {"mass": (0.0488, 0.0498), "x": (0.798, 0.802)},
        }
    )
    names = [c.name for c in rig.responses]
    gap = plain.gap.model_copy(
        update={
            "by_channel": {name: 200.0 + k for k, name in enumerate(names)},
            "after_by_channel": dict.fromkeys(names, 1.0),
            "by_record": {b.name: 100.0 for b in campaign.blocks} | {"impact_p10": 90.0},
            "share_nominal": ResponseShare(at_resonance=0.94, away=0.13),
            "share_before": ResponseShare(at_resonance=0.5, away=0.071),
            "share_after": ResponseShare(at_resonance=0.00005, away=None),
        }
    )
    rows = [
        BudgetRow(kind="effect", name="added_mass", place="", said="added mass", sigmas=None, share=1.02),
        BudgetRow(
            kind="tolerance", name="thickness", place="", said="thickness -0.10%", sigmas=-0.3, share=-0.02,
            by={"test": {"sine": -0.02}, "band": {"50-120": -0.02}},
        ),
    ]  # fmt: skip
    return plain.model_copy(
        update={
            "effects": [found],
            "gap": gap,
            "candidates": [
                CandidateSet(effects=["added_mass"], probability=1.0, gap=1.0),
                CandidateSet(effects=["stiffness_loss", "ground_spring"], probability=0.0, gap=120.0),
            ],
            "budget": Budget(rows=rows, calibrate=[]),
            "where": plain.where.model_copy(update={"x_m": 0.8 * rig.beam.length_m}),
        }
    )


@pytest.fixture(scope="module")
def page(diagnosis: Diagnosis, campaign: Campaign) -> str:
    return render(diagnosis, campaign).replace("\u00a0", " ")


def test_a_place_stands_in_words_with_its_interval(diagnosis: Diagnosis, page: str) -> None:
    assert place_of(diagnosis.effects[0]) == ("0.8000 m from the clamp", "0.7980 to 0.8020 m")
    assert "0.8000 m from the clamp (95 %: 0.7980 to 0.8020 m)" in page
    assert "{" not in re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)


def test_channels_have_names(rig: Rig) -> None:
    found = made_diagnosis(rig, SWAP)
    names = [c.name for c in rig.channels]
    assert place_of(found.effects[0], names) == (f"on {names[3]} and {names[7]}", "")
    assert f"on {names[3]} and {names[7]}" in verdict_sentence(found, names)
    assert "on channels 3 and 7" in verdict_sentence(found)


def test_an_answer_has_one_probability(page: str) -> None:
    assert set(re.findall(r"probability (\d\.\d+)", page)) <= {"0.99", "0.00"}


def test_numbers_have_the_digits_that_their_intervals_bear(page: str) -> None:
    assert "0.0493 kg" in page
    assert "0.0488 to 0.0498 kg" in page
    assert "0.049321" not in page


def test_the_gap_stands_in_noise_units_and_in_percent(page: str) -> None:
    assert "% at resonance" in page
    assert all(said in page for said in ("94 %", "7.1 %", "below 0.01 %"))


def test_percent_and_minus_are_set_alike() -> None:
    assert (
        typeset_sentence("a02 reads -1.8% low, 50-120 Hz").replace("\u00a0", " ")
        == "a02 reads \u22121.8 % low, 50-120 Hz"
    )


def test_bars_begin_at_zero_to_either_side() -> None:
    drawn = str(scaled_bars([Bar("up", 0.75, "75 %", "ink"), Bar("down", -0.25, "-25 %", "ink")], "both"))
    assert re.findall(r"left:([\d.]+)%;width:([\d.]+)%", drawn) == [("25.00", "75.00"), ("0.00", "25.00")]


def test_what_was_measured_is_drawn_with_its_residual(diagnosis: Diagnosis, campaign: Campaign) -> None:
    figure = gap_curves(diagnosis, campaign)
    assert figure is not None
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert sum("what is left" in t for t in titles) == 2
    assert sum("FRF" in t for t in titles) == 2
    assert all("[" in axes.get_ylabel() for axes in figure.axes)


def test_every_table_and_figure_of_the_page_is_well_formed(page: str) -> None:
    assert page.count("<figure") == page.count("<figcaption>") >= 5
    assert page.count("<section") == page.count("</section>")
    assert "rms of measured less simulated [noise units]" in page


@pytest.mark.parametrize("verdict", ["no_gap", "unknown"])
def test_a_page_without_effects_is_whole(rig: Rig, campaign: Campaign, verdict: str) -> None:
    bare = made_diagnosis(rig).model_copy(update={"verdict": verdict})
    assert "What causes it" not in render(bare, campaign)
