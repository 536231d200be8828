"""The modes that are integrated in time: real ones with a damping ratio each, or complex ones of a local damper.

In both, a mode is a first-order oscillator z' = p z + f, and a point moves as Im(sum of psi(x) psi(x_f) z / s).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.cantilever.modes import Modes

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Basis(Protocol):
    """What the bench integrates in time."""

    @property
    def poles(self) -> Complex:
        """p, with an imaginary part from 0, (modes,)."""
        ...

    @property
    def scale(self) -> Floats:
        """s, (modes,)."""
        ...

    def shapes(self, x_m: Floats, order: int = 0) -> Floats | Complex:
        """psi, displacement (order 0) or slope (1), in kg^-1/2, (points, modes)."""
        ...

    @property
    def modes(self) -> Modes:
        """The undamped modes behind it."""
        ...

    def project(self, rows: Floats) -> Floats | Complex:
        """psi of loads known by what they do to each undamped mode, (loads, modes behind) to (loads, modes)."""
        ...

    def remainder(self, x_m: Floats, force_x_m: float, put: int = 0) -> Floats:
        """Static displacement per force (put = 0) or moment (1) that all modes beyond add, (points,)."""
        ...

    @property
    def participation(self) -> Floats | Complex:
        """What an acceleration of the base puts into each mode, in kg^1/2, (modes,)."""
        ...

    def base_remainder(self, x_m: Floats) -> Floats:
        """Static displacement per acceleration of the base that all modes beyond add, in s^2, (points,)."""
        ...


@dataclass(frozen=True, eq=False)
class ModalBasis:
    """The first len(omega) modes of a structure, each with a damping ratio of its own."""

    beam: Modes
    omega: Floats
    zeta: Floats

    @property
    def poles(self) -> Complex:
        """p = -zeta omega + j omega sqrt(1 - zeta^2)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    @property
    def scale(self) -> Floats:
        """omega sqrt(1 - zeta^2)."""
        return self.poles.imag

    def shapes(self, x_m: Floats, order: int = 0) -> Floats:
        """At unit modal mass in kg^-1/2, (points, modes)."""
        return self.beam.shapes(x_m, len(self.omega), order)

    @property
    def modes(self) -> Modes:
        """The undamped modes behind it."""
        return self.beam

    def project(self, rows: Floats) -> Floats:
        """The first of them."""
        return rows[..., : len(self.omega)]

    def remainder(self, x_m: Floats, force_x_m: float, put: int = 0) -> Floats:
        """Static flexibility of all modes beyond, (points,)."""
        own = self.shapes(x_m) * self.shapes(np.array([force_x_m]), put) / self.omega**2
        return self.beam.flexibility(x_m, force_x_m, 0, put) - own.sum(axis=1)

    @property
    def participation(self) -> Floats:
        """Integral of mass times shape, against the base's acceleration."""
        return -self.beam.participation(len(self.omega))

    def base_remainder(self, x_m: Floats) -> Floats:
        """Of the modes beyond, up to three times as many."""
        return _base_beyond(self.beam, x_m, len(self.omega))


def _base_beyond(modes: Modes, x_m: Floats, kept: int) -> Floats:
    count = min(3 * kept, max(80, kept))
    share = -modes.participation(count) / modes.omega(count) ** 2
    return modes.shapes(x_m, count)[:, kept:] @ share[kept:]


@dataclass(frozen=True, slots=True)
class Damper:
    """A viscous damper to ground at `x_m`."""

    x_m: float
    c: float


class DampedBasis:
    """Complex modes of a structure with local dampers, from the state space of its first real modes.

    The damping matrix is that of the modes' own ratios plus c phi(x) phi(x)^T. It is symmetric, so left and right
    vectors are the same, and a_r = u^T (2 p_r + C) u scales them (Ewins, Modal Testing, 2.8).
    """

    def __init__(self, modes: Modes, zeta: Floats, dampers: Sequence[Damper], reach: float) -> None:
        self.modes = modes
        self._omega = modes.omega(len(zeta))
        self._poles, self._vectors = _complex_modes(modes, self._omega, zeta, dampers, reach)

    @property
    def poles(self) -> Complex:
        """p, (modes,)."""
        return self._poles

    @property
    def scale(self) -> Floats:
        """Imaginary part of p, or 1 where a mode does not swing."""
        return np.where(self._poles.imag > 0, self._poles.imag, 1.0)

    def shapes(self, x_m: Floats, order: int = 0) -> Complex:
        """psi, (points, modes)."""
        return self.modes.shapes(x_m, len(self._omega), order) @ self._vectors

    def project(self, rows: Floats) -> Complex:
        """By the complex modes' own share of each undamped one."""
        return rows[..., : len(self._omega)] @ self._vectors

    def remainder(self, x_m: Floats, force_x_m: float, put: int = 0) -> Floats:
        """Static flexibility of all modes beyond, (points,)."""
        own = self.shapes(x_m) * self.shapes(np.array([force_x_m]), put) / (-self._poles * self.scale)
        return self.modes.flexibility(x_m, force_x_m, 0, put) - own.imag.sum(axis=1)

    @property
    def participation(self) -> Complex:
        """Integral of mass times shape, against the base's acceleration."""
        return -self.modes.participation(len(self._omega)) @ self._vectors

    def base_remainder(self, x_m: Floats) -> Floats:
        """Of all real modes in the state space, less what the complex ones kept add."""
        real = -self.modes.participation(len(self._omega)) / self._omega**2
        own = self.shapes(x_m) * self.participation / (-self._poles * self.scale)
        return self.modes.shapes(x_m, len(self._omega)) @ real - own.imag.sum(axis=1)


def _complex_modes(
    modes: Modes, omega: Floats, zeta: Floats, dampers: Sequence[Damper], reach: float
) -> tuple[Complex, Complex]:
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
    poles: Complex = np.where(real, values.real, values)[keep]
    real = real[keep]
    order = np.argsort(np.abs(poles))
    poles, real = poles[order], real[order]
    u: Complex = (vectors[:n, keep] / omega[:, None])[:, order]
    a: Complex = np.einsum("ir,ir->r", u, 2 * poles * u + damping @ u)
    scale = np.where(real, 1.0, poles.imag)
    return poles, u * np.sqrt(np.where(real, 1j, 2j) * scale / a)


class JoinedBasis:
    """A basis beside another family of modes, which loads drive and sensors see by a share."""

    def __init__(self, main: Basis, side: ModalBasis, share: float) -> None:
        self._main, self._side, self._share = main, side, share

    @property
    def poles(self) -> Complex:
        """p of both, (modes,)."""
        return np.concatenate([self._main.poles, self._side.poles])

    @property
    def scale(self) -> Floats:
        """s of both, (modes,)."""
        return np.concatenate([self._main.scale, self._side.scale])

    def shapes(self, x_m: Floats, order: int = 0) -> Complex:
        """psi; a moment knows nothing of the family beside, (points, modes)."""
        count = len(self._side.omega)
        side = np.zeros((len(x_m), count)) if order else self._share * self._side.shapes(x_m)
        return _beside(self._main.shapes(x_m, order), side)

    @property
    def modes(self) -> Modes:
        """The undamped modes behind the main family."""
        return self._main.modes

    def project(self, rows: Floats) -> Complex:
        """psi of loads on the main family's undamped modes."""
        main = self._main.project(rows)
        return _beside(main, np.zeros((*main.shape[:-1], len(self._side.omega))))

    def remainder(self, x_m: Floats, force_x_m: float, put: int = 0) -> Floats:
        """Static displacement that all modes beyond add, (points,)."""
        main = self._main.remainder(x_m, force_x_m, put)
        return main if put else main + self._share**2 * self._side.remainder(x_m, force_x_m)

    @property
    def participation(self) -> Complex:
        """Of the main family: the base shakes along the drive."""
        return _beside(self._main.participation, np.zeros(len(self._side.omega)))

    def base_remainder(self, x_m: Floats) -> Floats:
        """Of the main family."""
        return self._main.base_remainder(x_m)


def _beside(main: Floats | Complex, side: Floats) -> Complex:
    return np.concatenate([main.astype(np.complex128), side.astype(np.complex128)], axis=-1)
