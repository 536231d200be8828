"""Responses to a force that was not measured against a model with a scale: poles, and shapes that lack theirs."""

import numpy as np
import pytest
from phased_line import model, rig, with_mass
from responses_alone import responses_alone

from modallab.core.errors import DataError
from modallab.gap.modal.diagnosis import diagnose_by_model

AGAIN = pytest.mark.thorough("diagnoses one more structure")


@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=AGAIN) for n in (2,))])
def test_a_sound_structure_has_no_gap(seed: int) -> None:
    assert diagnose_by_model(model(), responses_alone(model(), seed), rig()).verdict == "no_gap"


@AGAIN
def test_the_reference_gives_a_mass_its_size() -> None:
    (effect,) = diagnose_by_model(model(), responses_alone(with_mass(1.0, 3), 1), rig()).effects
    assert (effect.effect, effect.place.point) == ("added_mass", 3)
    low, high = effect.interval["mass"]
    assert low < 1.0 < high < 1.5


@AGAIN
def test_a_gain_is_that_of_its_channel() -> None:
    of = model()
    wrong = of.model_copy(update={"modal_constants": of.modal_constants * np.array([1.0, 1.3, 1.0])[None, :, None]})
    (effect,) = diagnose_by_model(of, responses_alone(wrong), rig()).effects
    assert (effect.effect, effect.place.channel) == ("gain_error", "a2")
    assert effect.parameters["gain"] == pytest.approx(1.3, rel=0.03)


def test_a_reference_of_responses_alone_has_nothing_to_give() -> None:
    with pytest.raises(DataError, match="share no output or no driven point"):
        diagnose_by_model(responses_alone(model()), responses_alone(model()), rig())
