"""A gap without a name is described by what it behaves like, and the description closes it on records held out."""

from collections.abc import Callable
from datetime import date

import numpy as np
import pytest

from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.design.prediction import predict_records
from modallab.gap.diagnosis import diagnose
from modallab.gap.revisions import with_diagnosis
from modallab.gap.simulations.simulated_records import simulation_residual
from modallab.gap.words.verdicts import verdict_sentence
from modallab.reporting.gap_report import render
from modallab_simulators.cantilever import open_bench

Make = Callable[..., Campaign]
HUNG = Effect(effect="point_law", parameters={"hung_m": 0.05, "hung_hz": 40.0}, place={"x": 0.62})


def nothing(name: str) -> bool:
    return False


@pytest.fixture(scope="module")
def hung(make: Make) -> tuple[Campaign, Diagnosis]:
    campaign = make(HUNG, tests=("impact",))
    return campaign, diagnose(campaign, allowed=nothing)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_mass_that_hangs_on_the_beam_is_placed_and_put_into_numbers(hung: tuple[Campaign, Diagnosis]) -> None:
    _, diagnosis = hung
    described = diagnosis.described
    assert diagnosis.verdict == "unknown"
    assert described is not None
    assert described.stage == "structure"
    assert described.x_m == pytest.approx(0.62, abs=0.02)
    assert described.elements[0].parameters["hung_hz"] == pytest.approx(40.0, rel=0.02)
    assert described.elements[0].parameters["hung_m"] == pytest.approx(0.05, rel=0.05)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_it_closes_the_gap_on_records_that_no_fit_has_seen(hung: tuple[Campaign, Diagnosis]) -> None:
    campaign, diagnosis = hung
    described = diagnosis.described
    assert described is not None
    assert described.shrink.closed is not None
    assert described.shrink.closed > 0.99
    bare = diagnosis.model_copy(update={"described": None})
    names = described.shrink.held_out
    with_it, without = (
        simulation_residual(campaign, predict_records(d, campaign), names).gap for d in (diagnosis, bare)
    )
    assert with_it < 0.05 * without


@pytest.mark.thorough("diagnoses a whole campaign")
def test_the_next_revision_carries_it_and_so_does_its_bench(hung: tuple[Campaign, Diagnosis]) -> None:
    campaign, diagnosis = hung
    revised = with_diagnosis(campaign.rig, diagnosis, date(2026, 5, 4))
    assert revised.known_effects[0].effect == "point_law"
    facts = open_bench("sim://cantilever?seed=1", revised.model_copy(update={"model": "cantilever"})).info.facts
    assert "point_law" in facts["effects"]


@pytest.mark.thorough("diagnoses a whole campaign")
def test_it_is_said_as_a_likeness(hung: tuple[Campaign, Diagnosis]) -> None:
    campaign, diagnosis = hung
    said = verdict_sentence(diagnosis)
    assert "no known effect explains it, probability 0.99. The gap behaves like a mass of" in said
    page = render(diagnosis, campaign)
    assert "Description of the unnamed cause" in page
    assert "This is no cause" in page


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_saturating_channel_is_described_by_its_level(make: Make, rig: Rig) -> None:
    def saturates(volts: np.ndarray, block: Block) -> np.ndarray:
        volts = volts.copy()
        volts[3] = 0.4 * np.tanh(volts[3] / 0.4)
        return volts

    described = diagnose(make(spoil=saturates), allowed=nothing).described
    assert described is not None
    assert described.channels == ["a03"]
    assert described.elements[0].element == "row_curve"
    assert described.elements[0].parameters == {"tanh_v": pytest.approx(0.4, rel=0.05)}
    assert described.shrink.closed is not None
    assert described.shrink.closed > 0.9


def test_where_there_is_no_gap_there_is_nothing_to_describe(make: Make) -> None:
    diagnosis = diagnose(make(tests=("impact",)), allowed=nothing)
    assert diagnosis.verdict == "no_gap"
    assert diagnosis.described is None
