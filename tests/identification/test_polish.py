"""A start pole put upon the last line moves to where the mode is, and a sound one stays."""

import numpy as np
import pytest
from test_plscf import frf

from modallab.identification.start.refine_start import misfit_of_trials, polish_poles

DRIVEN = np.array([3, 4, 5, 6, 8, 12, 18, 24, 28, 30, 31, 32, 33, 35, 40, 50, 60, 72, 84, 88, 90, 92, 96, 108]) / 1.024
BAND = (2.79, 110.7)
ZETA = np.array([0.0067, 0.0062, 0.0066])
PHI = np.array([[0.2, 0.6, 1.2, 1.8], [0.6, 1.2, 0.1, -1.8], [1.1, 0.2, -1.2, 1.8]])


def poles(frequency_hz, zeta):
    omega = 2 * np.pi * np.asarray(frequency_hz)
    return omega * (-np.asarray(zeta) + 1j * np.sqrt(1 - np.asarray(zeta) ** 2))


def stepped(top_hz):
    return frf([6.09, 38.15, top_hz], ZETA, PHI, [2], DRIVEN, "inertance", seed=None)


@pytest.mark.parametrize("top_hz", [105.6, 106.8, 108.5])
def test_a_pole_upon_the_last_line_moves_to_the_mode_beyond_it(top_hz):
    start = poles([6.09, 38.15, DRIVEN[-1]], [0.0067, 0.0062, 0.002])
    found = polish_poles(stepped(top_hz), start, BAND)
    np.testing.assert_allclose(np.abs(found) / (2 * np.pi), [6.09, 38.15, top_hz], rtol=1e-3)
    assert -found[2].real / abs(found[2]) == pytest.approx(ZETA[2], rel=0.1)


def test_a_start_that_little_can_be_gained_on_stays_as_it_is():
    noisy = frf([6.09, 38.15, 90.0], ZETA, PHI, [2], DRIVEN, "inertance", seed=0)
    start = poles([6.09, 38.15, 90.0], ZETA)
    np.testing.assert_array_equal(polish_poles(noisy, start, BAND), start)


def test_no_pole_leaves_the_band():
    start = poles([6.09, 38.15, DRIVEN[-1]], [0.0067, 0.0062, 0.002])
    found = np.abs(polish_poles(stepped(118.0), start, BAND)) / (2 * np.pi)
    assert np.all((found > BAND[0]) & (found < BAND[1] * (1 + 1e-9)))


def test_nothing_to_move_is_nothing_moved():
    assert polish_poles(stepped(90.0), np.zeros(0, complex), BAND).size == 0


def test_misfit_is_least_at_the_true_poles():
    true = poles([6.09, 38.15, 90.0], ZETA)
    trials = np.stack([true, true * 1.01, true * 0.99])
    left = misfit_of_trials(stepped(90.0), trials)
    assert np.argmin(left) == 0
    assert left[0] < 1e-6 * left[1]
