"""Elements that do not answer in proportion: each becomes a linear beam where its law is linear."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.twin.bench import Twin
from modallab.twin.modes import solve_modes
from modallab.twin.nonlinear import stepping
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw, couple_to_modes
from modallab.twin.predict import predict_hit, predict_sine
from modallab.twin.structure import TwinStructure

RATE = 2000.0
CHANNELS = (1, 2)
PLACES = np.array([0.4, 0.9])
BEAM = TwinStructure(0.9, 0.05, 0.006, 2.05e11, 7850.0, np.full(15, 0.006))
UNIT = BEAM.bending_stiffness / BEAM.length_m


def twin(root: float, element: NonlinearElement | None) -> Twin:
    return Twin(replace(BEAM, root_rotation=root), element=element, residual_compliance=1.0)


def hit(bench: Twin, newtons: float) -> NDArray[np.float64]:
    force = np.zeros(2048)
    force[100:116] = newtons * np.hanning(16)
    return predict_hit(bench, force, RATE, 0.5, CHANNELS, PLACES, 0.0)


def sine(bench: Twin, newtons: float) -> NDArray[np.float64]:
    return predict_sine(bench, complex(newtons), 23.0, 1024, 1000.0, 0.4, CHANNELS, PLACES, 0.0)


def off(seen: NDArray[np.float64], wanted: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(seen - wanted) / np.linalg.norm(wanted))


STICKS = twin(1 / 8, NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 1e9)))
TOUCHES = twin(1 / 8, NonlinearElement(NonlinearLaw.PLAY, 0.0, (12 * UNIT, 0.0)))
STIFF = twin(1 / 20, None)


@pytest.mark.parametrize("bench", [STICKS, TOUCHES])
def test_a_joint_that_never_lets_go_is_a_stiffer_root(bench: Twin) -> None:
    # Damping ratios belong to the modes of another root: what that leaves is small, but not nothing.
    assert off(sine(bench, 1.0), sine(STIFF, 1.0)) < 0.01
    assert off(hit(bench, 50.0)[:, :700], hit(STIFF, 50.0)[:, :700]) < 0.06


def test_a_slider_that_gives_way_at_once_leaves_the_softer_root() -> None:
    bench = twin(1 / 8, NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 1e-9)))
    assert off(sine(bench, 1.0), sine(twin(1 / 8, None), 1.0)) < 1e-6


def test_a_joint_that_yields_all_at_once_is_an_ideal_slider() -> None:
    ideal = twin(1 / 8, NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 0.05)))
    sharp, round_ = (
        twin(1 / 8, NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 0.05, n))) for n in (100.0, 1.5)
    )
    assert off(sine(sharp, 2.0), sine(ideal, 2.0)) < 0.02
    assert off(sine(round_, 2.0), sine(ideal, 2.0)) > 2 * off(sine(sharp, 2.0), sine(ideal, 2.0))


@pytest.mark.parametrize(
    "element",
    [
        NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 0.05)),
        NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 0.05, 1.5)),
        NonlinearElement(NonlinearLaw.PLAY, 0.0, (12 * UNIT, 1e-4)),
        NonlinearElement(NonlinearLaw.CUBIC, 0.7, (1e11,)),
        NonlinearElement(NonlinearLaw.DRAG, 0.0, (200.0,)),
    ],
)
def test_twice_the_force_is_not_twice_the_motion(element: NonlinearElement) -> None:
    bench = twin(1 / 8, element)
    assert off(sine(bench, 4.0), 4 * sine(bench, 1.0)) > 1e-3


def test_a_crack_answers_in_proportion_but_not_alike_both_ways() -> None:
    bench = twin(0.0, NonlinearElement(NonlinearLaw.CRACK, 0.2, (0.6, 0.036, 0.0)))
    assert off(sine(bench, 3.0), 3 * sine(bench, 1.0)) < 1e-9
    assert off(hit(bench, -50.0), -hit(bench, 50.0)) > 0.05


def test_a_drag_only_takes_energy() -> None:
    free, held = twin(0.0, None), twin(0.0, NonlinearElement(NonlinearLaw.DRAG, 0.0, (20.0,)))
    late = slice(1200, None)
    assert np.linalg.norm(hit(held, 80.0)[:, late]) < np.linalg.norm(hit(free, 80.0)[:, late])


def test_a_joint_that_turns_back_is_as_stiff_as_one_that_never_slipped() -> None:
    onward, back = (stepping.hysteresis_force(100.0, 1.0, 1.2, moved, 0.0, 0.0, 0.9, 0.9) for moved in (0.001, -0.001))
    assert back == pytest.approx(0.9 - 100.0 * 0.001)
    assert onward < 0.9 + 0.3 * 100.0 * 0.001


def test_a_drag_in_stations_and_an_even_one_have_the_same_total() -> None:
    modes = solve_modes(BEAM)
    even, lumped = (
        couple_to_modes(NonlinearElement(NonlinearLaw.DRAG, 0.0, (3.0, n)), BEAM, modes) for n in (0.0, 5.0)
    )
    assert sum(lumped.numbers) == pytest.approx(sum(even.numbers))
    assert len(lumped.numbers) == 5
