"""Points of a roving test that disagree give each mode once, with a sigma that holds; the one that is off is named."""

import functools

import numpy as np
import pytest

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.identification.setups.scatter import common_poles, random_effects, same_setup

F, ZETA = np.array([31.0, 31.6, 47.0]), np.array([0.004, 0.003, 0.005])
POINTS = 16
LINES = np.arange(25.0, 55.0, 0.05)


def measured(scatter=1e-3, seed=0, odd=None, transpose=False):
    rng = np.random.default_rng(seed)
    phi = rng.normal(size=(3, POINTS + 3))
    s, values = 2j * np.pi * LINES, np.zeros((POINTS, 3, LINES.size), complex)
    for k in range(POINTS):
        w = 2 * np.pi * F * (1 + scatter * rng.normal(size=3) + (0.01 if k == odd else 0))
        per_mode = s**2 / (s**2 + 2 * (ZETA * w)[:, None] * s + w[:, None] ** 2)
        values[k] = np.einsum("m,mi,ml->il", phi[:, k], phi[:, POINTS:], per_mode)
    level = 1e-3 * np.sqrt(np.mean(np.abs(values) ** 2))
    values += level * (rng.normal(size=values.shape) + 1j * rng.normal(size=values.shape))
    points, common = tuple(range(1, POINTS + 1)), tuple(range(101, 104))
    if transpose:
        values, points, common = values.transpose(1, 0, 2), common, points
    names = tuple(f"a{o}" for o in range(len(values)))
    return Frf(LINES, values, "inertance", names, points, common)


@functools.cache
def identified(**how):
    frf = measured(**how)
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=i, name=n, quantity="acceleration", unit="m/s^2") for i, n in enumerate(frf.outputs, 1)]
    return identify_frf(frf, Rig(name="roving", model="unknown", channels=tuple(channels)), IdentificationOptions())[0]


@pytest.mark.parametrize("transpose", [False, True])
def test_points_that_disagree_give_every_mode_once(transpose):
    model = identified(transpose=transpose)
    np.testing.assert_allclose(model.frequency_hz, F, rtol=2e-3)
    assert np.all(np.abs(model.frequency_hz - F) < 4 * model.frequency_sigma_hz)
    assert any("The points disagree" in note for note in model.notes)
    assert not any("share the pole" in note for note in model.notes)
    # Sixteen points that scatter by 0.1 % leave a mean that is known to 0.025 %.
    np.testing.assert_allclose(model.frequency_sigma_hz / F, 1e-3 / 4, rtol=0.6)


def test_points_that_agree_are_identified_by_one_set_of_poles():
    model = identified(scatter=0.0)
    assert np.all(model.frequency_sigma_hz / F < 1e-5)
    assert not any("disagree" in note for note in model.notes)


def test_a_point_that_is_off_is_named():
    assert any("set-up of point 6 is off" in note for note in identified(odd=5).notes)


def test_a_transposed_matrix_has_the_same_poles():
    one, other = identified(scatter=0.0), identified(scatter=0.0, transpose=True)
    np.testing.assert_allclose(one.frequency_hz, other.frequency_hz, rtol=1e-6)
    np.testing.assert_allclose(one.damping_ratio, other.damping_ratio, rtol=1e-4)


def test_a_shift_that_points_share_counts_once():
    rng = np.random.default_rng(1)
    shift = rng.normal(size=(4, 6)).repeat(5, axis=0)
    values = 100 + shift[..., None] + 0.01 * rng.normal(size=(20, 6, 2))
    variance = np.full(values.shape, 1e-4)
    np.testing.assert_array_equal(same_setup(values[..., 0], variance[..., 0]), np.arange(20) // 5)
    assert common_poles(values, variance).sigma[:, 0].mean() > 0.3


def test_a_mode_that_no_point_knows_by_itself_has_no_mean() -> None:
    variance = np.full((5, 2, 2), 1e-4)
    variance[:, 1, 1] = np.inf
    with pytest.raises(IdentificationError, match="no point knows the mode at 40 Hz"):
        common_poles(np.full(variance.shape, 80 * np.pi), variance)


def test_intervals_of_a_random_effect_hold():
    rng = np.random.default_rng(2)
    held = []
    for _ in range(200):
        mean, sigma, _ = random_effects(rng.normal(size=8) + 0.3 * rng.normal(size=8), np.full(8, 0.09))
        held.append(abs(mean) < 1.96 * sigma)
    assert 0.92 < np.mean(held) < 0.98
