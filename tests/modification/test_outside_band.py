"""What modes outside the band add at pairs that were not measured, and how far off that may be."""

import numpy as np
import pytest
from chain import BARE, Chain
from scipy.linalg import eigh

from modallab.modification.attachments import Element
from modallab.modification.known import KnownStructure
from modallab.modification.outside_band import SQUARES, complete_residual_terms, draw_residual_terms

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
        found = complete_residual_terms(truth[None, :, driven], (0,), range(POINTS), driven, moved, 1.0)
        others = np.setdiff1d(np.arange(POINTS), driven)
        own, alone = np.diag(found.terms[0])[others], found.alone[0, others]
        inside.append(np.abs(np.diag(truth)[others] - own) <= 1.96 * np.hypot(alone, 0.1 * own))
    assert np.mean(inside) > 0.9


def test_measured_pairs_stay_as_they_were_measured() -> None:
    truth, moved = chain(0)
    found = complete_residual_terms(truth[None, :, [3, 17]], (0,), range(POINTS), [3, 17], moved, 1.0)
    np.testing.assert_allclose(found.terms[0][:, [3, 17]], truth[:, [3, 17]], rtol=1e-12)
    np.testing.assert_array_equal(found.alone[0, [3, 17]], 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_samples_have_the_expected_mean_and_deviation(sign: float) -> None:
    alone = sign * np.array([[1.0, 4.0, 0.0]])
    many = draw_residual_terms(alone, np.random.default_rng(0).standard_normal((40_000, 3, SQUARES)))[:, 0]
    np.testing.assert_allclose(many.mean(axis=0), np.diag(alone[0]), atol=0.06)
    np.testing.assert_allclose(np.diagonal(many.std(axis=0)), np.abs(alone[0]), rtol=0.03)
    assert np.all(sign * np.linalg.eigvalsh(many[:100])[:, [0, -1]] > -1e-9)


def test_a_term_that_makes_no_whole_mode_below_the_band_does_not_act_on_what_is_hung_there() -> None:
    """A tenth of a mode, as a fit leaves it: below the lowest mode it would be most of the compliance."""
    held = BARE.model(driven=(1, 3))
    left = 0.1 * np.mean(held.modal_constants.real, axis=0)
    found = KnownStructure(held.model_copy(update={"residuals": left[None], "residual_powers": (-2,)}))
    added = [Element(1, spring=2e4), Element(4, mass=0.3)]
    expected = KnownStructure(held).with_changes(added).modes.frequency_hz
    np.testing.assert_allclose(found.with_changes(added).modes.frequency_hz, expected, rtol=1e-12)


def test_a_structure_that_hangs_free_keeps_the_term_of_the_modes_below_the_band() -> None:
    free = Chain.of([1.0, 2.0, 1.5, 1.0], [1e-3, 2e4, 3e4, 2e4, 0.0])
    whole = free.model(driven=(1, 3))
    above = {
        name: getattr(whole, name)[1:]
        for name in ("frequency_hz", "damping_ratio", "frequency_sigma_hz", "damping_sigma", "modal_constants",
                     "modal_constant_sigma", "half_power", "half_power_floor")
    }  # fmt: skip
    rigid = {"residuals": whole.modal_constants.real[:1], "residual_powers": (-2,)}
    found = KnownStructure(whole.model_copy(update=above | rigid)).with_changes([Element(3, mass=0.4)])
    heavier = Chain(free.mass + np.diag([0, 0, 0.4, 0]), free.damping, free.stiffness)
    expected = np.abs(heavier.poles()[-3:]) / (2 * np.pi)
    np.testing.assert_allclose(found.modes.frequency_hz[-3:], expected, rtol=1e-6)
