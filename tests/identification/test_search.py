"""What a search says of its own uncertainty."""

import numpy as np
import pytest

from modallab.identification.likelihood.search import covariance_of


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
