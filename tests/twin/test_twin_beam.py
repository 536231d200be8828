"""The finite elements against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.core.rig import Beam
from modallab.twin.modes import solve_modes
from modallab.twin.response import base_transmission
from modallab.twin.structure import TwinStructure

BEAM = Beam(length_m=1.0, width_m=0.05, thickness_m=0.002, youngs_modulus_pa=2.05e11, density_kg_m3=7850.0)
RIGID = TwinStructure.of(BEAM, 0.006)


def closed_form(count: int) -> np.ndarray:
    beta = [
        brentq(lambda b: np.cos(b) * np.cosh(b) + 1, (i + 0.5) * np.pi - 0.5, (i + 0.5) * np.pi + 0.5)
        for i in range(count)
    ]
    return np.array(beta) ** 2 * np.sqrt(RIGID.bending_stiffness / RIGID.mass_per_length) / (2 * np.pi)


def ratios(structure: TwinStructure) -> np.ndarray:
    f = solve_modes(structure).frequency_hz
    return f[1:3] / f[0]


def test_frequencies_are_those_of_a_clamped_free_beam() -> None:
    # A thin beam: rotary inertia takes less than 1e-4 off the fifth mode.
    assert solve_modes(RIGID).frequency_hz[:5] == pytest.approx(closed_form(5), rel=1e-4)


def test_a_soft_root_and_a_tip_mass_give_the_same_ratios() -> None:
    mass = RIGID.mass_per_length * RIGID.length_m
    assert ratios(replace(RIGID, root_rotation=1 / 13)) == pytest.approx([6.43, 18.33], abs=0.01)
    assert ratios(replace(RIGID, masses=((1.0, mass / 13),))) == pytest.approx([6.43, 18.33], abs=0.03)


def test_the_rig_file_says_how_soft_the_root_is() -> None:
    said = BEAM.model_copy(update={"clamp": "rotational spring of about 13 EI/L at x = 0"})
    assert TwinStructure.of(said, 0.006).root_rotation == pytest.approx(1 / 13)
    for words in ("rigid at x = 0", "welded in 1975", "a spring of 100 EI/L^3 across"):
        assert TwinStructure.of(BEAM.model_copy(update={"clamp": words}), 0.006).root_rotation == 0


def test_a_root_that_slides_freely_has_no_stiffness_left() -> None:
    f = solve_modes(replace(RIGID, root_translation=1e4)).frequency_hz
    assert f[0] < 0.02 * solve_modes(RIGID).frequency_hz[0]


def test_a_root_nearly_rigid_is_rigid() -> None:
    soft = solve_modes(replace(RIGID, root_rotation=2e-7, root_translation=2e-7)).frequency_hz[:6]
    assert soft == pytest.approx(solve_modes(RIGID).frequency_hz[:6], rel=3e-4)


@pytest.mark.parametrize("x", [0.3, 0.63, 1.0])
def test_a_small_mass_lowers_each_frequency_by_its_kinetic_energy(x: float) -> None:
    modes, small = solve_modes(RIGID), 1e-5
    moved = solve_modes(replace(RIGID, masses=((x, small),)))
    phi_squared = np.abs(modes.shapes_at(x)[0] ** 2 * 2j * modes.poles.imag)[:4]
    assert moved.frequency_hz[:4] / modes.frequency_hz[:4] - 1 == pytest.approx(
        -small * phi_squared / 2, rel=2e-3, abs=1e-9
    )


def test_a_ground_spring_raises_each_frequency_by_its_potential_energy() -> None:
    modes, k = solve_modes(RIGID), 1e-3
    moved = solve_modes(replace(RIGID, springs=((0.8, k),)))
    phi_squared = np.abs(modes.shapes_at(0.8)[0] ** 2 * 2j * modes.poles.imag)[:4]
    expected = k * phi_squared / 2 / (2 * np.pi * modes.frequency_hz[:4]) ** 2
    assert moved.frequency_hz[:4] / modes.frequency_hz[:4] - 1 == pytest.approx(expected, rel=2e-3, abs=1e-10)


def test_a_crack_softens_as_the_compliance_it_adds() -> None:
    # Thin limit: an extra hinge of compliance sqrt(pi) w s / EI at x, felt by the curvature there.
    x, width, share = 0.25, 0.01, 0.02
    modes = solve_modes(RIGID)
    moved = solve_modes(replace(RIGID, losses=((x, share, width),)))
    d = 1e-3
    curvature = (modes.shapes_at(x + d) - 2 * modes.shapes_at(x) + modes.shapes_at(x - d))[0] / d**2
    energy = RIGID.bending_stiffness * np.abs(curvature**2 * 2j * modes.poles.imag)[:3]
    expected = -0.5 * share * width * np.sqrt(np.pi) * energy / (2 * np.pi * modes.frequency_hz[:3]) ** 2
    assert moved.frequency_hz[:3] / modes.frequency_hz[:3] - 1 == pytest.approx(expected, rel=0.06)


def test_a_weak_damper_adds_its_own_damping_to_each_mode() -> None:
    c = 1e-3
    modes, damped = solve_modes(RIGID), solve_modes(replace(RIGID, dampers=((0.9, c),)))
    phi_squared = np.abs(modes.shapes_at(0.9)[0] ** 2 * 2j * modes.poles.imag)[:4]
    assert -damped.poles.real[:4] + modes.poles.real[:4] == pytest.approx(c * phi_squared / 2, rel=1e-3)


def test_a_strong_damper_keeps_the_response_reciprocal_and_real_in_time() -> None:
    modes = solve_modes(replace(RIGID, dampers=((1.0, 50.0),)))
    a, b = modes.shapes_at(0.4)[0], modes.shapes_at(0.9)[0]
    s = 2j * np.pi * 7.0
    forth, back = (np.sum(x * y / (s - modes.poles)) for x, y in ((a, b), (b, a)))
    assert forth == pytest.approx(back)
    assert np.all(modes.poles.real < 0)


def test_a_slowly_moving_base_carries_the_beam_with_it() -> None:
    x = np.array([0.1, 0.5, 1.0])
    slow, fast = 2j * np.pi * np.array([0.01]), 2j * np.pi * np.array([1.02 * solve_modes(RIGID).frequency_hz[0]])
    assert base_transmission(RIGID, x, slow).ravel() == pytest.approx(np.ones(3), abs=1e-3)
    assert np.abs(base_transmission(RIGID, x, fast)[2, 0]) > 10
