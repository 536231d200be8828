"""Modes of a structure's matrices, undamped or with local dampers, and what every set of them can be asked."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt
from typing import Protocol

import numpy as np

from modallab.core.arrays import Complex128, Real


def eigh(stiffness: Real, mass: Real | None = None) -> tuple[Real, Real]:
    """(n,) ascending eigenvalues and (n, n) eigenvectors, of unit modal mass, of (n, n) symmetric matrices.

    Without a mass matrix it is that of unity. With one, K v = omega^2 M v becomes a standard problem by M = L L^T
    (Golub and Van Loan, Matrix Computations, 8.7). SciPy has that too, but to import it takes every bench's process a
    quarter of the time in which it begins.
    """
    if mass is None:
        values, vectors = np.linalg.eigh(stiffness)
        return values, vectors
    lower = np.linalg.cholesky(mass)
    half = np.linalg.solve(lower, stiffness)
    standard = np.linalg.solve(lower, half.T)
    values, vectors = np.linalg.eigh((standard + standard.T) / 2)
    return values, np.asarray(np.linalg.solve(lower.T, vectors), dtype=np.float64)


class Modes(Protocol):
    """Modes at unit modal mass, ascending, and the statics they add up to. `count` may not exceed `limit`."""

    @property
    def length_m(self) -> float:
        """Of the beam."""
        ...

    @property
    def total_mass_kg(self) -> float:
        """Of all that moves."""
        ...

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        ...

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        ...

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement (order 0) or slope (1) of the modes in kg^-1/2, (points, count)."""
        ...

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        ...

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static displacement (seen = 0) or slope (1) at `x_m` per force (put = 0) or moment (1), (points,)."""
        ...


class SolvedModes(ABC):
    """Modes of a structure that differs from a bare one, by an eigenvalue problem of its own."""

    def __init__(self, bare: Modes) -> None:
        self._bare = bare

    @property
    def length_m(self) -> float:
        """Of the beam."""
        return self._bare.length_m

    @property
    def total_mass_kg(self) -> float:
        """Of all that moves."""
        return self._bare.total_mass_kg

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        return self._solved[0][:count]

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(np.searchsorted(self._solved[0], omega))

    @cached_property
    @abstractmethod
    def _solved(self) -> tuple[Real, Real]:
        """Natural frequencies in rad/s, (modes,), and each mode as a sum of the bare ones, (terms, modes)."""


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


POISSON = 0.3


@dataclass(frozen=True, slots=True)
class TorsionBar:
    """A bar clamped at x = 0, behind the interface of its modes; what moves is its angle in rad.

    Attributes:
        length_m: L.
        stiffness_n_m2: G J.
        inertia_kg_m: rho I_p, per length.
    """

    length_m: float
    stiffness_n_m2: float
    inertia_kg_m: float

    @classmethod
    def of(cls, length_m: float, width_m: float, thickness_m: float, modulus_pa: float, density: float) -> "TorsionBar":
        """A flat bar: J = w h^3 (1 / 3 - 0.21 h / w) (Roark, table 10.7), I_p = w h (w^2 + h^2) / 12."""
        shear = modulus_pa / (2 * (1 + POISSON))
        constant = width_m * thickness_m**3 * (1 / 3 - 0.21 * thickness_m / width_m)
        polar = width_m * thickness_m * (width_m**2 + thickness_m**2) / 12
        return cls(length_m, shear * constant, density * polar)

    @property
    def total_mass_kg(self) -> float:
        """Of its turning: the moment of inertia in kg m^2."""
        return self.inertia_kg_m * self.length_m

    def omega(self, count: int) -> Real:
        """Natural frequencies in rad/s, (count,)."""
        speed = sqrt(self.stiffness_n_m2 / self.inertia_kg_m)
        return self._waves(count) * speed

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(np.searchsorted(self.omega(400), omega))

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Angle of the modes, (points, count)."""
        if order:
            raise ValueError("the slope of an angle is not defined")
        angle: Real = np.sin(np.multiply.outer(x_m, self._waves(count)))
        angle *= sqrt(2 / self.total_mass_kg)
        return angle

    def participation(self, count: int) -> Real:
        """Nothing: a base that shifts turns no bar."""
        return np.zeros(count)

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static angle at `x_m` per moment about the bar's axis at `force_x_m`, (points,)."""
        near = np.minimum(x_m, force_x_m, dtype=np.float64)
        return near / self.stiffness_n_m2

    def _waves(self, count: int) -> Real:
        odd = np.arange(1, count + 1, dtype=np.float64) - 0.5
        return odd * (pi / self.length_m)


@dataclass(frozen=True, slots=True)
class SingleMode:
    """A mode along (x / L)^power, behind the interface of all modes.

    Attributes:
        length_m: L.
        hz: natural frequency.
        kg: mass that swings with the tip.
        power: of its shape.
    """

    length_m: float
    hz: float
    kg: float
    power: float

    @property
    def total_mass_kg(self) -> float:
        """Of what swings."""
        return self.kg

    def omega(self, count: int) -> Real:
        """Natural frequency in rad/s, (count,), of one mode at most."""
        return np.full(min(count, 1), 2 * pi * self.hz)

    def count_below(self, omega: float) -> int:
        """How many modes lie below `omega` in rad/s."""
        return int(2 * pi * self.hz < omega)

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement of the mode in kg^-1/2, (points, count)."""
        if order:
            raise ValueError("the slope of a single mode is not defined")
        return self._shape(x_m)[:, None][:, :count]

    def participation(self, count: int) -> Real:
        """Nothing: what swings is not known, so neither is what a base that shakes does to it."""
        return np.zeros(min(count, 1))

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static displacement at `x_m` per force at `force_x_m`, (points,)."""
        return self._shape(x_m) * float(self._shape(np.array([force_x_m]))[0]) / (2 * pi * self.hz) ** 2

    def _shape(self, x_m: Real) -> Real:
        grown: Real = (x_m / self.length_m) ** self.power
        return grown / sqrt(self.kg)
