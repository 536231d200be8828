"""Complex128 modes of a structure with local dampers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.modes import Modes


@dataclass(frozen=True, slots=True)
class Damper:
    """A viscous damper to ground at `x_m`."""

    x_m: float
    c: float


class DampedBasis:
    """Complex128 modes of a structure with local dampers, from the state space of its first real modes.

    The damping matrix is that of the modes' own ratios plus c phi(x) phi(x)^T. It is symmetric, so left and right
    vectors are the same, and a_r = u^T (2 p_r + C) u scales them (Ewins, Modal Testing, 2.8).
    """

    def __init__(self, modes: Modes, zeta: Real, dampers: Sequence[Damper], reach: float) -> None:
        self.modes = modes
        self._omega = modes.omega(len(zeta))
        self._poles, self._vectors = _complex_modes(modes, self._omega, zeta, dampers, reach)

    @property
    def poles(self) -> Complex128:
        """p, (modes,)."""
        return self._poles

    @property
    def scale(self) -> Real:
        """Imaginary part of p, or 1 where a mode does not swing."""
        return np.where(self._poles.imag > 0, self._poles.imag, 1.0)

    def shapes(self, x_m: Real, order: int = 0) -> Complex128:
        """psi, (points, modes)."""
        return self.modes.shapes(x_m, len(self._omega), order) @ self._vectors

    def project(self, rows: Real) -> Complex128:
        """By the complex modes' own share of each undamped one."""
        return rows[..., : len(self._omega)] @ self._vectors

    def remainder(self, x_m: Real, force_x_m: float, put: int = 0) -> Real:
        """Static flexibility of all modes beyond, (points,)."""
        own = self.shapes(x_m) * self.shapes(np.array([force_x_m]), put) / (-self._poles * self.scale)
        return self.modes.flexibility(x_m, force_x_m, 0, put) - own.imag.sum(axis=1)

    @property
    def participation(self) -> Complex128:
        """Integral of mass times shape, against the base's acceleration."""
        return -self.modes.participation(len(self._omega)) @ self._vectors

    def base_remainder(self, x_m: Real) -> Real:
        """Of all real modes in the state space, less what the complex ones kept add."""
        real = -self.modes.participation(len(self._omega)) / self._omega**2
        own = self.shapes(x_m) * self.participation / (-self._poles * self.scale)
        return self.modes.shapes(x_m, len(self._omega)) @ real - own.imag.sum(axis=1)


def _complex_modes(
    modes: Modes, omega: Real, zeta: Real, dampers: Sequence[Damper], reach: float
) -> tuple[Complex128, Complex128]:
    n = len(omega)
    damping = np.diag(2 * zeta * omega)
    for damper in dampers:
        row = modes.shapes(np.array([damper.x_m]), n)[0]
        damping += damper.c * np.outer(row, row)
    # Displacements in units of their own frequency keep the matrix balanced.
    state = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -damping]])
    solved = np.linalg.eig(state)
    values, vectors = solved.eigenvalues.astype(np.complex128), solved.eigenvectors.astype(np.complex128)
    real = np.abs(values.imag) < 1e-9 * np.abs(values)
    keep = (np.abs(values) < reach) & (real | (values.imag > 0))
    poles: Complex128 = np.where(real, values.real, values)[keep]
    real = real[keep]
    order = np.argsort(np.abs(poles))
    poles, real = poles[order], real[order]
    u: Complex128 = (vectors[:n, keep] / omega[:, None])[:, order]
    a: Complex128 = np.einsum("ir,ir->r", u, 2 * poles * u + damping @ u)
    scale = np.where(real, 1.0, poles.imag)
    return poles, u * np.sqrt(np.where(real, 1j, 2j) * scale / a)
