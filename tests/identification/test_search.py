"""What a search says of its own uncertainty."""

import numpy as np
import pytest

from modallab.identification.likelihood.equations import BlockEquations, NormalEquations, covariance_of


def test_the_covariance_is_the_inverse_whatever_the_units():
    plain = np.random.default_rng(3).standard_normal((40, 5))
    units = np.array([1e-6, 1.0, 1e4, 1e-2, 1e8])
    found = covariance_of(plain.T @ plain * np.outer(units, units))
    np.testing.assert_allclose(found * np.outer(units, units), np.linalg.inv(plain.T @ plain), rtol=1e-9)


@pytest.mark.parametrize("rounding", [0.0, -1e-17, 1e-17])
def test_what_cannot_be_distinguished_is_not_called_known(rounding):
    """A pseudoinverse would say that the difference of two equal columns is known without error."""
    matrix = np.array([[1.0, 1.0, 0.0], [1.0, 1.0 + rounding, 0.0], [0.0, 0.0, 4.0]])
    found = covariance_of(matrix)
    assert np.all(np.diag(found)[:2] > 1e12)
    assert found[2, 2] == pytest.approx(0.25)


def of_three_inputs(alike=False):
    """Normal equations of two poles' parameters and of 5, 0 and 3 more; `alike`: the poles differ in nothing."""
    rng = np.random.default_rng(5)
    parts = [rng.standard_normal((40, 4 + own)) for own in (5, 0, 3)]
    if alike:
        for part in parts:
            part[:, 2:4] = part[:, :2]
    grams = [part.T @ part for part in parts]
    places = np.split(4 + rng.permutation(8), [5, 5])
    inputs = [BlockEquations(at, g[4:, 4:], g[:4, 4:]) for at, g in zip(places, grams, strict=True)]
    return NormalEquations(sum(g[:4, :4] for g in grams), inputs, rng.standard_normal(12))


def test_a_step_solves_the_equations_of_all_inputs_together():
    equations = of_three_inputs()
    damped = equations.whole() + 0.1 * np.eye(12)
    np.testing.assert_allclose(damped @ equations.step(0.1), equations.pull, atol=1e-12)


@pytest.mark.parametrize("alike", [False, True])
def test_the_covariance_input_by_input_is_that_of_all_together(alike):
    equations = of_three_inputs(alike)
    whole, found = covariance_of(equations.whole()), equations.covariance()
    np.testing.assert_allclose(found.poles, whole[:4, :4], rtol=1e-9)
    for own, part in zip(equations.inputs, found.inputs, strict=True):
        at = np.concatenate([np.arange(4), own.at])
        np.testing.assert_allclose(part, whole[np.ix_(at, at)], rtol=1e-9, atol=1e-12)
    assert np.all(np.diag(found.poles) > 1e10) == alike
