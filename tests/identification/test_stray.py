"""An error of the model raises ranks and turns phases; neither makes a mode, and a weak mode is none the less one."""

import numpy as np
import pytest

from modallab.identification.repeated import split_repeated
from modallab.identification.stray import out_of_step

POINTS = tuple(range(1, 9))
DRIVEN = (2, 5, 8)
ROWS = [p - 1 for p in DRIVEN]
SIGMA = np.full((1, 8, 3), 1e-6)


def modes(*, size=1.0, seed=0):
    """Two modes of one pole; the second `size` times as strong."""
    rng = np.random.default_rng(seed)
    phi = rng.choice([-1.0, 1.0], (2, 8)) * rng.uniform(0.5, 1.0, (2, 8))
    # At the driven points they move differently enough to be told apart.
    phi[:, ROWS] = [[1.0, 0.6, 0.8], [-0.7, 0.9, 0.3]]
    phi[1] *= np.sqrt(size)
    return phi.T @ phi[:, ROWS] + 0j


@pytest.mark.parametrize("size", [1.0, 0.3, 0.1])
@pytest.mark.parametrize("seed", range(5))
def test_two_modes_on_one_pole_are_two(size, seed):
    found = split_repeated(modes(size=size, seed=seed)[None], SIGMA, POINTS, DRIVEN)
    assert found.pole.tolist() == [0, 0]


@pytest.mark.parametrize("seed", range(10))
def test_two_modes_with_sensors_some_percent_off_are_still_two(seed):
    gain = np.random.default_rng(seed).uniform(0.97, 1.03, (8, 1))
    found = split_repeated((gain * modes(seed=seed))[None], SIGMA, POINTS, DRIVEN)
    assert found.pole.tolist() == [0, 0]


@pytest.mark.parametrize("seed", range(20))
def test_one_mode_that_each_blow_sees_a_little_otherwise_is_one(seed):
    """As when the pole is not quite the same for every point: ranks above the noise, but not reciprocal."""
    rng = np.random.default_rng(seed)
    phi = rng.uniform(0.3, 1.0, 8)
    one = np.outer(phi, phi[ROWS]) * (1 + 0.08 * (rng.standard_normal((8, 3)) + 1j * rng.standard_normal((8, 3))))
    assert np.linalg.svd(one, compute_uv=False)[1] > 0.02 * np.linalg.svd(one, compute_uv=False)[0]
    found = split_repeated(one[None], SIGMA, POINTS, DRIVEN)
    assert found.pole.tolist() == [0]
    np.testing.assert_array_equal(found.constants[0], one)


LEAST = 50.0
STRENGTHS = np.array([5000.0, 3000.0, 54.0, 900.0])


def constants(turned_rad=0.0, *, all_of_them=False, noise=0.0):
    """Four modes at eight points from two forces, the third weak and its points out of step."""
    rng = np.random.default_rng(1)
    shapes = rng.choice([-1.0, 1.0], (4, 8)) * rng.uniform(0.5, 1.0, (4, 8)) + 0j
    turn = np.exp(1j * turned_rad * np.linspace(-2, 2, 8))
    shapes[slice(None) if all_of_them else 2] *= turn
    values = shapes[:, :, None] * np.array([1.0, 0.6])
    values += noise * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)) / np.sqrt(2)
    return values, np.full(values.shape, max(noise, 1e-3))


def test_a_weak_pole_out_of_step_is_stray():
    assert out_of_step(*constants(0.3), STRENGTHS, LEAST).tolist() == [False, False, True, False]


def test_a_weak_mode_in_step_stays():
    assert not out_of_step(*constants(), STRENGTHS, LEAST).any()


def test_a_weak_mode_stays_where_noise_alone_turns_its_phases():
    assert not out_of_step(*constants(noise=0.15), STRENGTHS, LEAST).any()


def test_a_strong_mode_stays_whatever_its_phases():
    assert not out_of_step(*constants(0.3), np.maximum(STRENGTHS, 900.0), LEAST).any()


def test_where_the_strong_modes_are_out_of_step_too_the_structure_is_so():
    assert not out_of_step(*constants(0.3, all_of_them=True), STRENGTHS, LEAST).any()


def test_two_sensors_have_no_phases_to_compare():
    values, sigma = constants(0.3)
    assert not out_of_step(values[:, :2], sigma[:, :2], STRENGTHS, LEAST).any()
