"""What errors of stiffness and mass do to modes, beside modes of matrices with such errors."""

import numpy as np
from scipy.linalg import eigh

from modallab.updating.posterior import model_error_covariance

HZ = np.array([5.0, 30.0, 31.0, 86.0, 170.0, 300.0])
MEASURED = np.array([0, 2, 1, 3])
SIZE, DRAWS = 1e-5, 3000


def drawn(shapes: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Over their size, what one error of stiffness and mass moves of the measured modes."""
    off = rng.standard_normal((2, HZ.size, HZ.size))
    off = SIZE * (off + off.transpose(0, 2, 1)) / np.sqrt(2)
    squares, vectors = eigh(np.diag(HZ**2) + off[0] * np.outer(HZ, HZ), np.eye(HZ.size) + off[1])
    moved = (vectors * np.sign(np.diag(vectors))).T @ shapes - shapes
    return np.concatenate([np.log(np.sqrt(squares) / HZ)[MEASURED], moved[MEASURED].ravel()]) / SIZE


def test_the_covariance_is_that_of_modes_of_matrices_with_such_errors() -> None:
    rng = np.random.default_rng(0)
    shapes = rng.standard_normal((HZ.size, 4))
    stated = model_error_covariance(HZ, shapes, MEASURED)
    many = np.array([drawn(shapes, rng) for _ in range(DRAWS)])
    sigma = np.sqrt(np.diag(stated))
    assert np.abs(many.T @ many / DRAWS - stated).max() < 0.1 * np.outer(sigma, sigma).max()
    assert np.allclose(many.std(axis=0), sigma, rtol=0.1)


def test_frequencies_have_unit_variance_and_close_modes_stay_finite() -> None:
    same = np.array([10.0, 10.0, 20.0])
    covariance = model_error_covariance(same, np.eye(3), np.arange(3))
    assert np.allclose(np.diag(covariance)[:3], 1)
    assert np.isfinite(covariance).all()
