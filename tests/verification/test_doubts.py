"""What hardly stands out, and what one sensor sees alone, is reported; a mode of the structure is not."""

import numpy as np
import pytest
from test_comparison import SHAPES, model

from modallab.verification.assessment import doubtful_mode_sentences, output_of_isolated_mode

SURE = np.array([0.9, 0.95, 0.99])


def from_two_points(shapes, sigma=1e-3):
    """The same shapes seen from points 1 and 4."""
    one = model(shapes)
    constants = np.stack([shapes * 1.0, shapes * 0.7], axis=2) + 0j
    return one.model_copy(
        update={
            "input_points": (1, 4),
            "modal_constants": constants,
            "modal_constant_sigma": np.full(constants.shape, sigma),
        }
    )


def test_sound_modes_raise_no_doubt():
    assert doubtful_mode_sentences(from_two_points(SHAPES), SURE) == ()


def test_confidence_that_is_not_known_raises_none_either():
    assert doubtful_mode_sentences(from_two_points(SHAPES), np.full(3, np.nan)) == ()


@pytest.mark.parametrize(("weak", "says"), [((1,), "The mode at 30 Hz is"), ((0, 2), "The modes at 5, 80 Hz are")])
def test_a_mode_that_hardly_stands_out_is_reported_by_its_frequency(weak, says):
    confidence = SURE.copy()
    confidence[list(weak)] = 0.07
    (sentence,) = doubtful_mode_sentences(from_two_points(SHAPES), confidence)
    assert sentence.startswith(says)


def test_a_mode_that_one_sensor_has_to_itself_is_reported_with_the_sensor():
    shapes = SHAPES.copy()
    shapes[1] *= np.where(np.arange(6) == 3, 1.0, 1e-3)
    (sentence,) = doubtful_mode_sentences(from_two_points(shapes), SURE)
    assert "30 Hz" in sentence
    assert "a3 alone" in sentence
    assert output_of_isolated_mode(from_two_points(shapes)).tolist() == [-1, 3, -1]


def test_a_part_that_moves_by_itself_and_is_driven_itself_is_a_mode():
    shapes = SHAPES.copy()
    shapes[1] *= np.where(np.arange(6) == 3, 1.0, 1e-3)
    driven = from_two_points(shapes)
    constants = driven.modal_constants.copy()
    constants[1, :, 0] = 0
    assert doubtful_mode_sentences(driven.model_copy(update={"modal_constants": constants}), SURE) == ()


def test_few_sensors_cannot_show_who_is_alone():
    assert output_of_isolated_mode(model(SHAPES[:, :3], points=(1, 2, 3))).tolist() == [-1, -1, -1]
