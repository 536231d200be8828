import numpy as np
import pytest

from modallab.identification.likelihood.orthonormal import qr_decomposition


@pytest.mark.parametrize("condition", [1.0, 1e4, 1e7, 1e10, 1e13])
def test_columns_are_orthonormal_and_give_the_matrix_back_however_alike_they_are(condition):
    rng = np.random.default_rng(2)
    u, _ = np.linalg.qr(rng.standard_normal((400, 12)))
    v, _ = np.linalg.qr(rng.standard_normal((12, 12)))
    tall = u * np.geomspace(1, 1 / condition, 12) @ v
    q, r = qr_decomposition(tall)
    np.testing.assert_allclose(q.T @ q, np.eye(12), atol=1e-13)
    np.testing.assert_allclose(q @ r, tall, atol=1e-14)
    assert np.all(np.tril(r, -1) == 0)


def test_equal_columns_do_not_stop_it():
    tall = np.ones((50, 2))
    q, r = qr_decomposition(tall)
    np.testing.assert_allclose(q @ r, tall, atol=1e-13)
    assert abs(r[1, 1]) < 1e-13
