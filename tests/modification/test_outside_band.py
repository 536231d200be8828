"""What modes outside the band add at pairs that were not measured, and how far off that may be."""

import numpy as np
import pytest
from scipy.linalg import eigh

from modallab.modification.outside_band import SQUARES, complete_residuals, draw_residuals

POINTS, WITHIN = 30, 10


def chain(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Compliance (points, points) of the modes above the band, and squared shapes (points,) within it."""
    rng = np.random.default_rng(seed)
    mass, spring = np.exp(0.5 * rng.standard_normal((2, POINTS)))
    stiffness = np.diag(spring + np.append(spring[1:], 0)) - np.diag(spring[1:], 1) - np.diag(spring[1:], -1)
    squared, phi = eigh(stiffness, np.diag(mass))
    above = phi[:, WITHIN:]
    return (above / squared[WITHIN:]) @ above.T, np.sum(phi[:, :WITHIN] ** 2, axis=1)


def test_own_pair_of_a_point_that_was_not_driven_lies_in_its_interval() -> None:
    inside = []
    for seed in range(20):
        truth, moved = chain(seed)
        rng = np.random.default_rng(seed)
        driven = list(rng.choice(POINTS, 2, replace=False))
        found = complete_residuals(truth[None, :, driven], (0,), range(POINTS), driven, moved, 1.0)
        others = np.setdiff1d(np.arange(POINTS), driven)
        own, alone = np.diag(found.terms[0])[others], found.alone[0, others]
        inside.append(np.abs(np.diag(truth)[others] - own) <= 1.96 * np.hypot(alone, 0.1 * own))
    assert np.mean(inside) > 0.9


def test_measured_pairs_stay_as_they_were_measured() -> None:
    truth, moved = chain(0)
    found = complete_residuals(truth[None, :, [3, 17]], (0,), range(POINTS), [3, 17], moved, 1.0)
    np.testing.assert_allclose(found.terms[0][:, [3, 17]], truth[:, [3, 17]], rtol=1e-12)
    np.testing.assert_array_equal(found.alone[0, [3, 17]], 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_samples_have_the_expected_mean_and_deviation(sign: float) -> None:
    alone = sign * np.array([[1.0, 4.0, 0.0]])
    many = draw_residuals(alone, np.random.default_rng(0).standard_normal((40_000, 3, SQUARES)))[:, 0]
    np.testing.assert_allclose(many.mean(axis=0), np.diag(alone[0]), atol=0.06)
    np.testing.assert_allclose(np.diagonal(many.std(axis=0)), np.abs(alone[0]), rtol=0.03)
    assert np.all(sign * np.linalg.eigvalsh(many[:100])[:, [0, -1]] > -1e-9)
