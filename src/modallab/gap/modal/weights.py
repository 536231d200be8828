"""How a misfit is weighed: each FRF by the covariance of its lines."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real


@dataclass(frozen=True, eq=False, slots=True)
class Weights:
    """Of the lines of every FRF, real parts before imaginary parts.

    Attributes:
        whitening: (FRFs, 2 lines, 2 lines) inverse of the covariance's Cholesky factor.
    """

    whitening: Real

    @classmethod
    def of(cls, sigma: Real, shapes: Complex, spread: Real, noise: Complex | None = None) -> "Weights":
        """Of lines that are off by sigma each, by terms along all of them, and by noise.

        Args:
            sigma: (lines, outputs, inputs) of a real or an imaginary part.
            shapes: (terms, lines) each over the lines.
            spread: (terms, outputs, inputs) deviation of each.
            noise: (lines, lines, outputs, inputs) covariance of complex numbers.
        """
        lines, frfs = sigma.shape[0], sigma[0].size
        one = np.concatenate([shapes.real, shapes.imag], axis=1)
        along = np.einsum("tl,tf->flt", one, spread.reshape(len(one), frfs))
        covariance = along @ along.transpose(0, 2, 1)
        own = np.tile(sigma.reshape(lines, frfs).T ** 2, 2)
        if noise is not None:
            covariance += _of_parts(noise.reshape(lines, lines, frfs).transpose(2, 0, 1))
        every = np.arange(2 * lines)
        covariance[:, every, every] += own
        size = np.sqrt(covariance[:, every, every])
        factor = np.linalg.cholesky(covariance / (size[:, :, None] * size[:, None, :]))
        return cls(np.linalg.inv(factor) / size[:, None, :])

    @property
    def logdet(self) -> float:
        """Logarithm of the determinant of the whole covariance."""
        return float(-2 * np.sum(np.log(np.abs(np.diagonal(self.whitening, axis1=1, axis2=2)))))

    def weighed(self, misfit: Complex) -> Real:
        """(FRFs 2 lines, any number) of misfits (any number, lines, outputs, inputs), in deviations."""
        n, lines = misfit.shape[:2]
        flat = misfit.reshape(n, lines, -1).transpose(2, 1, 0)
        return (self.whitening @ np.concatenate([flat.real, flat.imag], axis=1)).reshape(-1, n)


def _of_parts(noise: Complex) -> Real:
    """(FRFs, 2 lines, 2 lines) of circular complex noise (FRFs, lines, lines)."""
    return np.block([[noise.real, -noise.imag], [noise.imag, noise.real]]) / 2
