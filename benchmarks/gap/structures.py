"""A cantilever plate and a cantilever tube by Ritz's method: benches beside the beam, of physics that no twin has.

The plate is Kirchhoff's, clamped along x = 0, thickness and density varying over it. The tube bends in two planes of
slightly different stiffness, twists, and ovals in both orientations; a mass on its wall couples all of these. Axial
functions are Legendre polynomials times the power of x that the clamp asks for. Sources: Leissa, "Vibration of Plates",
NASA SP-160 (1969); Blevins, Formulas for Dynamics, Acoustics and Vibration (2016), for the ring that ovals.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import eigh

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Matrices:
    """Mass and stiffness in Ritz coordinates, and where they show: (x, y, z) and an axis -> (coordinates,) row."""

    mass: Real
    stiffness: Real
    row: Callable[[Real, str], Real]

    def modes(self, count: int) -> tuple[Real, Real]:
        """(count,) rad/s and (coordinates, count) at unit modal mass."""
        squared, vectors = eigh(self.stiffness, self.mass, subset_by_index=(0, count - 1))
        return np.sqrt(squared), vectors


def axial(n: int, power: int, xi: Real, derivative: int = 0) -> Real:
    """(n, places) derivatives by xi of xi^power P_k(2 xi - 1)."""
    return np.array([_series(k, power, derivative)(xi) for k in range(n)])


@cache
def _series(k: int, power: int, derivative: int) -> np.polynomial.Polynomial:
    series = legendre.Legendre.basis(k, domain=[0, 1]).convert(kind=np.polynomial.Polynomial)
    whole = np.polynomial.Polynomial([0] * power + [1]) * series
    return whole.deriv(derivative) if derivative else whole


def field(rng: np.random.Generator, sigma: float) -> Callable[[Real], Real]:
    """A factor about 1 along xi: three cosines of deviation sigma, as the beam's benches have."""
    a = sigma * rng.standard_normal(3)
    return lambda xi: 1 + sum(a[k] * np.cos((k + 1) * np.pi * xi) for k in range(3))


def even(_: Real) -> Real:
    """No variation."""
    return np.ones_like(_)


@dataclass(frozen=True)
class Material:
    """E, rho and thickness as factors of their nominal values, and how they vary along x (and y)."""

    youngs: float = 1.0
    density: float = 1.0
    thickness: float = 1.0
    stiff_x: Callable[[Real], Real] = even
    stiff_y: Callable[[Real], Real] = even
    mass_x: Callable[[Real], Real] = even


PLATE_M = (0.6, 0.4)
TUBE_M, RADIUS_M = 1.2, 0.05


def plate(material: Material) -> Matrices:
    """600 x 400 x 4 mm of aluminium."""
    length, width = PLATE_M
    h, nu, n = 0.004 * material.thickness, 0.33, 9
    rigidity = 70e9 * material.youngs * h**3 / (12 * (1 - nu**2))
    nodes, weights = legendre.leggauss(24)
    xi, w = (nodes + 1) / 2, weights / 2
    fx = [axial(n, 2, xi, d) / length**d for d in range(3)]
    fy = [axial(n, 0, xi, d) / width**d for d in range(3)]
    area = length * width * np.outer(w, w)
    stiff = rigidity * area * np.outer(material.stiff_x(xi), material.stiff_y(xi))
    inertia = 2700 * material.density * h * area * np.outer(material.mass_x(xi), np.ones_like(xi))

    def products(dx: int, dy: int) -> Real:
        return np.einsum("ia,jb->ijab", fx[dx], fy[dy]).reshape(n * n, -1)

    shape, xx, yy, xy = products(0, 0), products(2, 0), products(0, 2), products(1, 1)
    k, m = stiff.ravel(), inertia.ravel()
    stiffness = (xx * k) @ xx.T + (yy * k) @ yy.T + nu * ((xx * k) @ yy.T + (yy * k) @ xx.T)
    stiffness += 2 * (1 - nu) * (xy * k) @ xy.T

    def row(at: Real, axis: str) -> Real:
        if axis != "z":
            return np.zeros(n * n)
        return np.outer(axial(n, 2, at[:1] / length), axial(n, 0, at[1:2] / width)).ravel()

    return Matrices((shape * m) @ shape.T, stiffness, row)


def tube(material: Material) -> Matrices:
    """1.2 m of steel tube, 100 mm in diameter, wall 2.2 mm; the stiffer plane is turned by 25 degrees."""
    length, radius, h, n = TUBE_M, RADIUS_M, 0.0022 * material.thickness, 8
    youngs, rho = 205e9 * material.youngs, 7850 * material.density
    per_m, second = rho * 2 * np.pi * radius * h, np.pi * radius**3 * h
    nodes, weights = legendre.leggauss(24)
    xi = (nodes + 1) / 2
    k, m = weights / 2 * length * material.stiff_x(xi), weights / 2 * length * material.mass_x(xi)
    bend = [axial(n, 2, xi, d) / length**d for d in range(3)]
    twist = [axial(n, 1, xi, d) / length**d for d in range(2)]
    turned = np.deg2rad(25.0)
    plane = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    ei = plane.T @ np.diag([1.006, 0.994]) @ plane * youngs * second
    kb, mb = (bend[2] * k) @ bend[2].T, (bend[0] * m) @ bend[0].T
    # Ovalling, radial a cos 2 theta and tangential -a/2 sin 2 theta: inextensional ring, and the wall's own stretching
    # along the axis where a changes with x (u = R/4 a' cos 2 theta) as a beam on that foundation.
    ring = youngs * h**3 / (12 * (1 - 0.3**2)) * 9 * np.pi / radius**3
    along = youngs * h * np.pi * radius**3 / 16
    oval_k = ring * (bend[0] * k) @ bend[0].T + along * kb
    oval_m = rho * h * np.pi * radius * 1.25 * mb
    torsion_k = youngs / 2.6 * 2 * np.pi * radius**3 * h * (twist[1] * k) @ twist[1].T
    torsion_m = rho * 2 * np.pi * radius**3 * h * (twist[0] * m) @ twist[0].T
    zero = np.zeros((n, n))
    cross = ei[0, 1] * kb
    stiffness = np.block(
        [
            [ei[0, 0] * kb, cross, zero, zero, zero],
            [cross, ei[1, 1] * kb, zero, zero, zero],
            [zero, zero, torsion_k, zero, zero],
            [zero, zero, zero, oval_k, zero],
            [zero, zero, zero, zero, 1.012 * oval_k],
        ]
    )
    mass = np.block(
        [
            [block if i == j else zero for j in range(5)]
            for i, block in enumerate([per_m * mb, per_m * mb, torsion_m, oval_m, oval_m])
        ]
    )

    def row(at: Real, axis: str) -> Real:
        theta = np.arctan2(at[2], at[1])
        f, g = axial(n, 2, at[:1] / length)[:, 0], axial(n, 1, at[:1] / length)[:, 0]
        radial, around = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
        k = "yz".find(axis)
        if k < 0:
            return np.zeros(5 * n)
        one = np.cos(2 * theta) * radial[k] - 0.5 * np.sin(2 * theta) * around[k]
        other = np.sin(2 * theta) * radial[k] + 0.5 * np.cos(2 * theta) * around[k]
        return np.concatenate([f * (k == 0), f * (k == 1), radius * around[k] * g, one * f, other * f])

    return Matrices(mass, stiffness, row)


def with_mass(of: Matrices, at: Real, kg: float) -> Matrices:
    """The same with a point mass, which moves along every axis."""
    rows = np.array([of.row(at, axis) for axis in "xyz"])
    return Matrices(of.mass + kg * rows.T @ rows, of.stiffness, of.row)


def with_spring(of: Matrices, at: Real, axis: str, k: float) -> Matrices:
    """The same with a spring to ground."""
    row = of.row(at, axis)
    return Matrices(of.mass, of.stiffness + k * np.outer(row, row), of.row)
