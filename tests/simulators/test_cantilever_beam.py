"""Modes of the beam against closed forms, quadrature and the exact continuous solution."""

import math

import numpy as np
import pytest

from modallab_simulators.cantilever.beam import CantileverBeam, unit_shapes, wave_numbers

CLAMPED_FREE = [1.875104068711961, 4.694091132974175, 7.854757438237613, 10.995540734875467, 14.137168391046471]
HINGED_FREE = [3.926602312047919, 7.068582745628732, 10.210176122813031]
KAPPAS = [1e-6, 0.3, 1.0, 13.0, 1e4, math.inf]


def link(kappa: float) -> CantileverBeam:
    return CantileverBeam(0.777, 205e9 * 0.05 * 0.004**3 / 12, 7850 * 0.05 * 0.004, kappa)


def test_rigid_clamp_gives_the_tabulated_roots():
    np.testing.assert_allclose(wave_numbers(5, math.inf), CLAMPED_FREE, rtol=1e-14)
    np.testing.assert_allclose(wave_numbers(5, 1e12), CLAMPED_FREE, rtol=1e-11)


def test_soft_root_gives_a_hinge_and_a_swinging_rigid_body():
    b = wave_numbers(4, 1e-9)
    np.testing.assert_allclose(b[1:], HINGED_FREE, rtol=1e-9)
    # omega^2 = k / (rho A L^3 / 3), so b^4 = 3 kappa.
    assert b[0] == pytest.approx((3e-9) ** 0.25, rel=1e-9)


def test_high_modes_follow_the_asymptote():
    n = np.arange(1, 201)
    np.testing.assert_allclose(wave_numbers(200, math.inf)[20:], ((n - 0.5) * math.pi)[20:], rtol=1e-14)


def test_root_spring_of_13_gives_the_papers_ratios():
    f = link(13.0).omega(3) / (2 * math.pi)
    np.testing.assert_allclose(f / f[0], [1, 6.43, 18.33], rtol=2e-3)


@pytest.mark.parametrize("kappa", KAPPAS)
def test_shapes_are_orthonormal(kappa: float):
    nodes, weights = np.polynomial.legendre.leggauss(400)
    shapes = unit_shapes((nodes + 1) / 2, wave_numbers(60, kappa), kappa)
    gram = shapes.T @ (shapes * (weights / 2)[:, None])
    np.testing.assert_allclose(gram, np.eye(60), atol=2e-12)


@pytest.mark.parametrize("kappa", KAPPAS)
def test_boundary_conditions_hold(kappa: float):
    h = 1e-4
    b = wave_numbers(3, kappa)
    root = unit_shapes(np.arange(5) * h, b, kappa)
    slope = (-25 / 12 * root[0] + 4 * root[1] - 3 * root[2] + 4 / 3 * root[3] - root[4] / 4) / h
    bend = (35 / 12 * root[0] - 26 / 3 * root[1] + 19 / 2 * root[2] - 14 / 3 * root[3] + 11 / 12 * root[4]) / h**2
    assert np.abs(root[0]).max() < 1e-12
    if kappa == math.inf:
        np.testing.assert_allclose(slope, 0, atol=1e-6)
    else:
        np.testing.assert_allclose(bend, kappa * slope, rtol=2e-3, atol=1e-5)


def test_modal_series_is_the_static_flexibility():
    beam = link(13.0)
    x = beam.length_m * np.arange(1, 11) / 10
    shapes, omega = beam.shapes(x, 150), beam.omega(150)
    for j in (0, 4, 9):
        series = (shapes * shapes[j] / omega**2).sum(axis=1)
        np.testing.assert_allclose(series, beam.flexibility(x, float(x[j])), rtol=2e-6)


@pytest.mark.parametrize("f_hz", [1.0, 20.0, 60.0, 300.0])
def test_modal_series_is_the_receptance_of_the_continuous_beam(f_hz: float):
    """Against the boundary-value problem solved directly: EI w'''' = omega^2 m w with a unit force at the tip."""
    beam = link(13.0)
    omega = 2 * math.pi * f_hz
    beta = (omega**2 * beam.mass_kg_m / beam.bending_stiffness_n_m2) ** 0.25
    s, c, sh, ch = (g(beta * beam.length_m) for g in (math.sin, math.cos, math.sinh, math.cosh))
    k = beam.kappa / beam.length_m
    # Unknowns A sin + B cos + C sinh + D cosh; rows: W(0), EI W'' = k W' at the root, W''(L), EI W'''(L) = -F.
    matrix = np.array([[0, 1, 0, 1], [-k, -beta, -k, beta], [-s, -c, sh, ch], [-c, s, ch, sh]], dtype=float)
    load = np.array([0, 0, 0, -1 / (beam.bending_stiffness_n_m2 * beta**3)])
    a, b, cc, d = np.linalg.solve(matrix, load)
    exact = a * s + b * c + cc * sh + d * ch
    tip = np.array([beam.length_m])
    count = 40
    modes = beam.shapes(tip, count)[0] ** 2 / (beam.omega(count) ** 2 - omega**2)
    rest = beam.flexibility(tip, beam.length_m)[0] - (beam.shapes(tip, count)[0] ** 2 / beam.omega(count) ** 2).sum()
    assert modes.sum() + rest == pytest.approx(exact, rel=1e-7)


def test_count_below_counts_the_modes():
    beam = link(13.0)
    omega = beam.omega(12)
    assert beam.count_below(float(omega[8]) * (1 + 1e-9)) == 9
    assert beam.count_below(float(omega[8]) * (1 - 1e-9)) == 8
    assert beam.count_below(0.5 * float(omega[0])) == 0
