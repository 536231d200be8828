"""A joint beside what a beam's higher modes give way: two twins that answer alike."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.gap.search.series_stiffness import in_series
from modallab.twin.bench import Twin
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw
from modallab.twin.predict import predict_sine
from modallab.twin.structure import TwinStructure

BEAM = TwinStructure(0.9, 0.05, 0.006, 2.05e11, 7850.0, np.full(15, 0.006), root_rotation=1 / 8)
UNIT = BEAM.bending_stiffness / BEAM.length_m
PLACES = np.array([0.4, 0.9])


def play(stiffness: float, share: float) -> Twin:
    return Twin(BEAM, element=NonlinearElement(NonlinearLaw.PLAY, 0.0, (stiffness, 1e-4)), residual_compliance=share)


def sine(twin: Twin) -> np.ndarray:
    return predict_sine(twin, 2.0 + 0j, 23.0, 1024, 1000.0, 0.4, (1, 2), PLACES, 0.0)


@pytest.mark.parametrize("stiffness", [12 * UNIT, 40 * UNIT])
def test_a_stiffer_joint_with_all_modes_acts_as_a_softer_one_without(stiffness: float) -> None:
    few = play(stiffness, 0.0)
    stiffer = in_series(few, stiffness, 1.0)
    assert stiffer is not None
    assert stiffer > 1.15 * stiffness
    whole = play(stiffer, 1.0)
    apart = np.linalg.norm(sine(whole) - sine(few))
    # With the stiffness as it was, the two are many times further apart.
    assert apart < 0.1 * np.linalg.norm(sine(play(stiffness, 1.0)) - sine(few))
    assert in_series(whole, stiffer, 0.0) == pytest.approx(stiffness, rel=1e-9)


def test_beside_all_modes_no_joint_is_stiff_enough_to_act_as_a_rigid_one_without() -> None:
    assert in_series(replace(play(1e9 * UNIT, 0.0)), 1e9 * UNIT, 1.0) is None
