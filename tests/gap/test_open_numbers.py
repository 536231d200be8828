"""A number that the records leave open has no interval but a reason, in the document and in words."""

import numpy as np
import pytest
from made_diagnosis import made_diagnosis

from modallab.core.diagnosis import FoundEffect
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.search.intervals import NO_ORDER, NO_PLACE, NO_SHARE, NOT_FELT, UNFELT, interval, reason_not_known
from modallab.gap.words.effects import parameter_in_words, place_of
from modallab.gap.words.verdicts import verdict_sentence
from modallab.twin.candidate import FreeNumber, along_beam
from modallab.twin.effects import model_of

STIFFNESS = FreeNumber("k3", "log", (1e6,))
LOSS = FreeNumber("EI_loss", "share", (0.5,), high=0.97)


@pytest.mark.parametrize(
    ("slot", "u", "deviation", "why"),
    [
        (STIFFNESS, np.log(1e6), 0.1, ""),
        (STIFFNESS, np.log(1e6), 1.5, NO_ORDER),
        (STIFFNESS, np.log(1e6), UNFELT, NOT_FELT),
        (LOSS, 0.0, 0.1, ""),
        (LOSS, 0.0, 1.5, NO_SHARE),
        (along_beam(), 0.8, 0.1, ""),
        (along_beam(), 0.6, 0.4, NO_PLACE),
    ],
)
def test_only_what_the_records_tell_has_an_interval(slot: FreeNumber, u: float, deviation: float, why: str) -> None:
    assert reason_not_known(slot, u, deviation, 0.0) == why


def test_a_positive_number_is_never_believed_to_be_negative() -> None:
    low, high = interval(STIFFNESS, np.log(1e6), 0.3, 0.8)
    assert 0 < low < 1e6 < high
    # For a well known number a share of it and a step of its logarithm are the same.
    low, high = interval(STIFFNESS, np.log(1e6), 0.003, 0.004)
    assert (low, high) == pytest.approx((1e6 * (1 - 1.96 * 0.005), 1e6 * (1 + 1.96 * 0.005)), rel=1e-4)


def test_a_share_stays_a_share() -> None:
    low, high = interval(LOSS, 3.0, 0.3, 0.5)
    assert 0 <= low < high <= 1


def opened(rig: Rig) -> FoundEffect:
    spring = Effect(effect="cubic_spring", parameters={"k3": 6.6e7}, place={"x": 0.8, "x_m": 0.6})
    (found,) = made_diagnosis(rig, spring).effects
    return found.model_copy(update={"interval": {"k3": None, "x": None}, "not_known": {"k3": NO_ORDER, "x": NO_PLACE}})


def test_the_sentence_says_no_number_that_is_not_known(rig: Rig) -> None:
    said = verdict_sentence(made_diagnosis(rig).model_copy(update={"effects": [opened(rig)]}))
    assert "cubic spring somewhere along the beam (cubic stiffness not known;" in said
    assert "6.6" not in said


def test_the_report_says_why(rig: Rig) -> None:
    (k3,) = model_of("cubic_spring").kind.parameters
    assert parameter_in_words(opened(rig), k3) == ("about 7×10⁷ N/m^3", f"not known: {NO_ORDER}")
    assert place_of(opened(rig)) == ("somewhere along the beam", f"not known: {NO_PLACE}")


def test_the_document_says_null_and_why(rig: Rig) -> None:
    document = opened(rig).model_dump(mode="json")
    assert document["interval"] == {"k3": None, "x": None}
    assert document["not_known"] == {"k3": NO_ORDER, "x": NO_PLACE}
    assert FoundEffect.model_validate(document) == opened(rig)
