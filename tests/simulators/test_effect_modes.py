"""Modes of changed structures against transcendental equations, shooting and invariants."""

from collections.abc import Callable
from math import cos, cosh, inf, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, newton

from modallab_simulators.cantilever.assembled import PreloadedModes
from modallab_simulators.cantilever.attached import Absorber, AttachedModes, Attachment
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.cracked import HALF_WIDTH, CrackedBeam, LocalStiffnessLoss
from modallab_simulators.cantilever.modes import DampedBasis, Damper, Modes, TorsionBar

BEAM = CantileverBeam(0.887, 205e9 * 0.05 * 0.004**3 / 12, 7850 * 0.05 * 0.004, inf)
EI, L, M = BEAM.bending_stiffness_n_m2, BEAM.length_m, BEAM.total_mass_kg
K, KT = EI / L**3, EI / L
RATE = sqrt(EI / BEAM.mass_kg_m) / L**2


def omega_of(equation: Callable[[float], float], count: int) -> np.ndarray:
    """Frequencies from the roots b of a frequency equation, found where it changes sign."""
    grid = np.linspace(0.05, (count + 2) * pi, 4000)
    values = [equation(b) for b in grid]
    edges = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0]
    return np.array([brentq(equation, grid[i], grid[i + 1], xtol=1e-14) for i in edges[:count]]) ** 2 * RATE


@pytest.mark.parametrize("share", [1e-4, 0.1, 1.0, 10.0])
def test_tip_mass(share: float):
    def equation(b: float) -> float:
        return (1 + cos(b) * cosh(b) + share * b * (cos(b) * sinh(b) - sin(b) * cosh(b))) / cosh(b)

    omega = AttachedModes(BEAM, [Attachment(L, mass=share * M)]).omega(10)
    np.testing.assert_allclose(omega, omega_of(equation, 10), rtol=1e-8)


@pytest.mark.parametrize("apart", [0.0, 1e-16, 1e-9])
def test_two_masses_a_hair_apart_are_one(apart: float):
    two = [Attachment(0.8 * L, mass=0.1 * M), Attachment((0.8 + apart) * L, mass=0.2 * M)]
    one = AttachedModes(BEAM, [Attachment(0.8 * L, mass=0.3 * M)])
    np.testing.assert_allclose(AttachedModes(BEAM, two).omega(10), one.omega(10), rtol=1e-7)


@pytest.mark.parametrize("k", [1.0, 50.0, 1e5])
def test_spring_at_the_tip(k: float):
    def equation(b: float) -> float:
        return (b**3 * (1 + cos(b) * cosh(b)) + k * (sin(b) * cosh(b) - cos(b) * sinh(b))) / cosh(b)

    omega = AttachedModes(BEAM, [Attachment(L, stiffness=k * K)]).omega(10)
    np.testing.assert_allclose(omega, omega_of(equation, 10), rtol=1e-8)


@pytest.mark.parametrize("k", [0.1, 5.0, 1e4])
def test_rotational_spring_at_the_tip(k: float):
    def equation(b: float) -> float:
        return (b * (1 + cos(b) * cosh(b)) + k * (cos(b) * sinh(b) + sin(b) * cosh(b))) / cosh(b)

    omega = AttachedModes(BEAM, [Attachment(L, 1, stiffness=k * KT)]).omega(10)
    np.testing.assert_allclose(omega, omega_of(equation, 10), rtol=1e-6)


def test_root_that_shifts():
    """Rotation held: b^3 (cos sinh + sin cosh) = k (1 + cos cosh); without a spring it swings as a whole."""
    for k in (1.0, 20.0, 300.0, 1e6):

        def equation(b: float, k: float = k) -> float:
            return (k * (1 + cos(b) * cosh(b)) - b**3 * (cos(b) * sinh(b) + sin(b) * cosh(b))) / cosh(b)

        omega = AttachedModes(BEAM, [], k * K).omega(8)
        np.testing.assert_allclose(omega, omega_of(equation, 8), rtol=1e-6)
    assert AttachedModes(BEAM, [], 0.01 * K).omega(1)[0] == pytest.approx(sqrt(0.01 * K / M), rel=1e-3)


def test_a_hold_at_a_point_makes_it_a_support():
    """A huge mass or spring at the tip: clamped and pinned, tan b = tanh b."""
    pinned = omega_of(lambda b: sin(b) - cos(b) * sinh(b) / cosh(b), 8)
    np.testing.assert_allclose(AttachedModes(BEAM, [Attachment(L, stiffness=1e9 * K)]).omega(8), pinned, rtol=1e-6)
    np.testing.assert_allclose(AttachedModes(BEAM, [Attachment(L, mass=1e7 * M)]).omega(9)[1:], pinned, rtol=1e-6)


def test_many_light_masses_are_a_heavier_beam():
    places = [Attachment(L * (k + 0.5) / 40, mass=0.2 * M / 40) for k in range(40)]
    np.testing.assert_allclose(AttachedModes(BEAM, places).omega(4), BEAM.omega(4) / sqrt(1.2), rtol=2e-4)


def shot(loss: LocalStiffnessLoss, omega: float) -> float:
    """Determinant of moment and shear at the tip, of two solutions shot from the clamp."""
    width = HALF_WIDTH * L

    def slope(x: float, y: np.ndarray) -> np.ndarray:
        stiffness = EI * (1 - loss.share * np.exp(-(((x - loss.x_m) / width) ** 2)))
        a, b = y.reshape(2, 4)
        return np.concatenate([(w[1], w[2] / stiffness, w[3], BEAM.mass_kg_m * omega**2 * w[0]) for w in (a, b)])

    start = [0, 0, EI / L**2, 0, 0, 0, 0, EI / L**3]
    end = solve_ivp(slope, (0, L), start, rtol=1e-10, atol=1e-14, max_step=width / 2).y[:, -1]
    return float(end[2] * end[7] - end[3] * end[6])


@pytest.mark.parametrize(("x", "share"), [(0.25, 0.75), (0.02, 0.6), (0.6, 0.95)])
def test_loss_of_stiffness_against_shooting(x: float, share: float):
    loss = LocalStiffnessLoss(x * L, share)
    for omega in CrackedBeam(BEAM, [loss]).omega(4):
        assert brentq(lambda w: shot(loss, w), omega * 0.999, omega * 1.001, rtol=1e-9) == pytest.approx(
            omega, rel=1e-6
        )


def test_a_shallow_loss_follows_the_curvature():
    """Rayleigh: the share of a mode's strain energy that is lost."""
    loss, s = LocalStiffnessLoss(0.3 * L, 1e-4), np.linspace(0, L, 20_001)
    curvature = BEAM.shapes(s, 6, 2)
    lost = EI * 1e-4 * np.exp(-(((s - loss.x_m) / (HALF_WIDTH * L)) ** 2))
    energy = np.trapezoid(lost[:, None] * curvature**2, s, axis=0)
    fall = 1 - (CrackedBeam(BEAM, [loss]).omega(6) / BEAM.omega(6)) ** 2
    np.testing.assert_allclose(fall, energy / BEAM.omega(6) ** 2, rtol=1e-3)


def structures() -> dict[str, Modes]:
    soft = CantileverBeam(L, EI, BEAM.mass_kg_m, 7.0)
    cracked = CrackedBeam(BEAM, [LocalStiffnessLoss(0.2 * L, 0.7), LocalStiffnessLoss(0.5 * L, 0.3)])
    mixed = [Attachment(0.63 * L, mass=0.3 * M), Attachment(0.3 * L, stiffness=40 * K), Attachment(0.4 * L, 1, 0.0, KT)]
    return {
        "attached": AttachedModes(soft, mixed, 300 * K),
        "hung": AttachedModes(BEAM, mixed, inf, [Absorber(0.7 * L, 0.05 * M, 3 * K)]),
        "cracked": cracked,
        "cracked and attached": AttachedModes(cracked, mixed),
        "preloaded": PreloadedModes(BEAM, 200.0),
    }


@pytest.mark.parametrize("name", structures())
def test_the_modal_series_is_the_static_flexibility(name: str):
    modes, x = structures()[name], L * np.arange(1, 11) / 10
    shapes, omega = modes.shapes(x, 70), modes.omega(70)
    for j in (0, 4, 9):
        series = (shapes * shapes[j] / omega**2).sum(axis=1)
        exact = modes.flexibility(x, float(x[j]))
        np.testing.assert_allclose(series, exact, rtol=0, atol=1e-5 * exact.max())
    turned = (modes.shapes(x, 70, 1) * shapes[4] / omega**2).sum(axis=1)
    np.testing.assert_allclose(turned, modes.flexibility(x, float(x[4]), 1, 0), rtol=2e-4)


@pytest.mark.parametrize("name", structures())
def test_a_shift_of_the_base_moves_the_whole_mass(name: str):
    modes = structures()[name]
    # Where the root is held, what the modes left out carry falls with their number only.
    assert (modes.participation(75) ** 2).sum() == pytest.approx(modes.total_mass_kg, rel=8e-3)


def test_an_absorber_on_a_stiff_beam_swings_by_itself():
    hung = AttachedModes(BEAM, [], inf, [Absorber(0.5 * L, 1e-6 * M, 1e-6 * M * 10.0**2)])
    assert hung.omega(1)[0] == pytest.approx(10.0, rel=1e-3)
    assert hung.attached_modes() == [0]
    np.testing.assert_allclose(hung.omega(5)[1:], BEAM.omega(4), rtol=1e-5)


def test_a_strut_buckles_at_eulers_load():
    euler = pi**2 * EI / (4 * L**2)
    assert PreloadedModes(BEAM, -euler * (1 - 1e-6)).omega(1)[0] < 3e-3 * BEAM.omega(1)[0]
    # The first mode is nearly the shape that buckles, so the square of its frequency falls nearly in proportion.
    assert PreloadedModes(BEAM, -euler / 2).omega(1)[0] / BEAM.omega(1)[0] == pytest.approx(sqrt(0.5), rel=0.03)


def test_torsion_of_a_flat_bar():
    bar = TorsionBar.of(1.0, 0.05, 0.004, 205e9, 7850.0)
    # c = 2 (h / w) sqrt(G / rho) for a very flat section; a quarter wave in the first mode.
    speed = 2 * 0.004 / 0.05 * sqrt(205e9 / 2.6 / 7850)
    assert bar.omega(1)[0] / (2 * pi) == pytest.approx(speed / 4, rel=0.04)
    np.testing.assert_allclose(bar.omega(3) / bar.omega(1)[0], [1, 3, 5])
    x = np.array([0.3, 1.0])
    series = (bar.shapes(x, 4000) * bar.shapes(x, 4000)[1] / bar.omega(4000) ** 2).sum(axis=1)
    np.testing.assert_allclose(series, bar.flexibility(x, 1.0), rtol=2e-4)


@pytest.mark.parametrize("c", [0.01, 0.5, 3.0])
def test_tip_damper_against_the_complex_frequency_equation(c: float):
    """With s = j b^2 (in units of the beam's), b^3 (1 + cos cosh) + s c (sin cosh - cos sinh) = 0."""
    unit = sqrt(EI * M / L**3)
    # The complex frequency equation knows no other damping.
    modes = DampedBasis(BEAM, np.full(80, 1e-12), [Damper(L, c * unit)], 1e9)
    poles = modes.poles[modes.poles.imag > 0][:6]

    def equation(b: complex) -> complex:
        return b**3 * (1 + np.cos(b) * np.cosh(b)) + 1j * b**2 * c * (np.sin(b) * np.cosh(b) - np.cos(b) * np.sinh(b))

    for pole in poles:
        b = newton(equation, np.sqrt(pole / (1j * RATE)), tol=1e-13)
        assert pole == pytest.approx(1j * b**2 * RATE, rel=3e-5)


def test_a_damper_that_holds_is_a_support_and_an_overdamped_mode_does_not_swing():
    unit = sqrt(EI * M / L**3)
    modes = DampedBasis(BEAM, np.full(80, 1e-9), [Damper(L, 1e3 * unit)], 1e9)
    swinging = modes.poles[modes.poles.imag > 0]
    pinned = AttachedModes(BEAM, [Attachment(L, stiffness=1e9 * K)]).omega(4)
    np.testing.assert_allclose(np.abs(swinging[:4]), pinned, rtol=1e-3)
    assert (modes.poles.imag == 0).any()
    assert (modes.poles.real < 0).all()
