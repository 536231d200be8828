"""Steps in time: their lines, their start, and how fine they must be."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.twin.modes import solve_modes
from modallab.twin.nonlinear import records
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw, couple_to_modes
from modallab.twin.nonlinear.records import FineSteps
from modallab.twin.nonlinear.sampling import rising_sine
from modallab.twin.nonlinear.steps import ModalSteps
from modallab.twin.structure import TwinStructure

BEAM = TwinStructure(0.9, 0.05, 0.006, 2.05e11, 7850.0, np.full(15, 0.006))
UNIT = BEAM.bending_stiffness / BEAM.length_m
DT, N, SHAKER = 1e-3, 1024, 0.36
SPRING = NonlinearElement(NonlinearLaw.CUBIC, 0.63, (1e9,))
JOINT = NonlinearElement(NonlinearLaw.FRICTION, 0.0, (12 * UNIT, 0.05, 1.2))
PLAY = NonlinearElement(NonlinearLaw.PLAY, 0.0, (12 * UNIT, 1e-4))
CRACK = NonlinearElement(NonlinearLaw.CRACK, 0.2, (0.6, 0.036, 0.0))
DRAG = NonlinearElement(NonlinearLaw.DRAG, 0.0, (20.0, 5.0))


def in_sine(
    element: NonlinearElement, hz: float, monkeypatch: pytest.MonkeyPatch | None = None, least: int = 0
) -> FineSteps:
    if monkeypatch is not None:
        monkeypatch.setattr(records, "LEAST", dict.fromkeys(NonlinearLaw, least))
        monkeypatch.setattr(records, "MOST", least)
    structure = replace(BEAM, root_rotation=1 / 8 if element.law in (NonlinearLaw.PLAY, NonlinearLaw.FRICTION) else 0.0)
    modes = solve_modes(structure)
    steps = records.prepared_steps(modes, couple_to_modes(element, structure, modes), DT, SHAKER)
    return records.element_response_in_sine(steps, element.law, 3 + 1j, hz, N, DT, 2.0, 0.5, False)


def felt(fine: FineSteps, order: int, hz: float) -> NDArray[np.complex128]:
    """What the element adds to the accelerations of the low modes at a multiple of the sine."""
    motion, _ = fine.on_lines(np.round(order * hz * N * DT) + np.arange(-2.0, 3.0))
    kept = len(motion) // 2
    swing = solve_modes(BEAM).poles[:4, None] ** 2
    return swing * (motion[:4] + 1j * motion[kept : kept + 4])


@pytest.mark.parametrize("element", [SPRING, JOINT, PLAY, CRACK, DRAG])
def test_lines_straight_from_the_steps_are_those_of_the_samples(element: NonlinearElement) -> None:
    fine = in_sine(element, 23.4)
    lines = np.array([-24.0, 0.0, 23.0, 24.0, 25.0, 72.0])
    motion, force = fine.on_lines(lines)
    modes, sampled = fine.sampled()
    whole = np.fft.fft(np.concatenate([modes.real, modes.imag, sampled.T]))[:, lines.astype(int)]
    assert np.concatenate([motion, force]) == pytest.approx(whole, abs=1e-10 * np.abs(whole).max())


@pytest.mark.parametrize("element", [SPRING, JOINT, PLAY, CRACK, DRAG])
@pytest.mark.parametrize("first", [10, 300])
def test_lines_of_a_hit_are_those_of_its_samples(element: NonlinearElement, first: int) -> None:
    modes = solve_modes(BEAM)
    steps = records.prepared_steps(modes, couple_to_modes(element, BEAM, modes), DT, SHAKER)
    fine = records.element_response_in_hit(steps, 40 * np.hanning(7), first, N)
    many, few = np.arange(1.0, 400.0), np.array([-24.0, 3.0, 24.0])
    modes_sampled, force_sampled = fine.sampled()
    whole = np.fft.fft(np.concatenate([modes_sampled.real, modes_sampled.imag, force_sampled.T]))
    for lines in (many, few):
        found = np.concatenate(fine.on_lines(lines))
        assert found == pytest.approx(whole[:, lines.astype(int)], abs=1e-10 * np.abs(whole).max())


@pytest.mark.parametrize(
    "element",
    [NonlinearElement(NonlinearLaw.CUBIC, 0.63, (-1e14,)), NonlinearElement(NonlinearLaw.DRAG, 0.0, (-1e9, 5.0))],
)
def test_motion_that_grows_without_bound_has_no_lines(element: NonlinearElement) -> None:
    modes = solve_modes(BEAM)
    steps = records.prepared_steps(modes, couple_to_modes(element, BEAM, modes), DT, SHAKER)
    for fine in (records.element_response_in_hit(steps, 400 * np.hanning(7), 300, N), in_sine(element, 23.4)):
        assert np.all(np.isnan(np.concatenate(fine.on_lines(np.array([23.0, 24.0])))))


def test_the_state_that_a_known_force_leaves_is_that_of_all_its_steps() -> None:
    modes = solve_modes(BEAM)
    steps = ModalSteps.of(modes, couple_to_modes(SPRING, BEAM, modes), DT / 4, SHAKER)
    force, state = np.random.default_rng(0).normal(size=1300), np.zeros(steps.kept, dtype=complex)
    for f in force:
        state = steps.decay * state + steps.drive * f
    assert steps.state_after(force) == pytest.approx(state)


@pytest.mark.parametrize("cosine", [False, True])
def test_a_sine_rises_from_rest_to_its_amplitude(cosine: bool) -> None:
    out, step, ahead = np.empty(9000), 0.11, 8000.0
    rising_sine(2 - 1j, step, ahead, 0.25, 1000.0, cosine, out)
    share = np.minimum((np.arange(9000) + 0.25) / 1000.0, 1.0)
    rise = (1 - np.cos(np.pi * share)) / 2 if cosine else share
    assert out == pytest.approx(rise * np.real((2 - 1j) * np.exp(1j * step * (np.arange(9000) - ahead))), abs=1e-10)


@pytest.mark.parametrize(
    ("element", "hz", "least", "off"),
    [
        # With forces that run straight in a step 8e-3 and 3.5e-4.
        (SPRING, 101.3, 2, 2e-3),
        (CRACK, 23.4, 3, 2.5e-4),
        (JOINT, 23.4, 4, 2.5e-4),
        (PLAY, 23.4, 8, 5e-5),
    ],
)
def test_as_fine_as_they_are_the_steps_agree_with_far_finer_ones(
    element: NonlinearElement, hz: float, least: int, off: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = felt(in_sine(element, hz, monkeypatch, least), 1, hz)
    fine = felt(in_sine(element, hz, monkeypatch, 32), 1, hz)
    assert np.linalg.norm(coarse - fine) / np.linalg.norm(fine) < off


@pytest.mark.parametrize("stiffness", [20.0, 400.0, 5000.0])
def test_a_stiff_contact_does_not_swing(stiffness: float) -> None:
    structure = replace(BEAM, root_rotation=10.0)
    modes = solve_modes(structure)
    own = couple_to_modes(NonlinearElement(NonlinearLaw.PLAY, 0.0, (stiffness * UNIT, 0.0)), structure, modes)
    force = np.zeros(8000)
    force[5:20] = 3.0
    pushed = ModalSteps.of(modes, own, DT / 4, SHAKER).run(force, 0).forces[0]
    assert np.abs(pushed[4000:]).max() < np.abs(pushed[:2000]).max()
