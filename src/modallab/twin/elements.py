"""Finite elements of the Euler-Bernoulli beam with rotary inertia, as patterns that are assembled once a length."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import Real, gauss_legendre

ELEMENTS = 40
"""Hermite elements; points at tenths of the length are nodes."""
FIELD_TERMS = 3
"""Cosine terms of the smooth fields EI(x) and rhoA(x)."""


@dataclass(frozen=True, eq=False, slots=True)
class BeamMatrices:
    """Matrices of a beam of unit EI and unit rhoA; index 0 is uniform, j the field cos(j pi x / L).

    Attributes:
        stiffness: (terms + 1, n, n) m^-3.
        mass: (terms + 1, n, n) m, translational.
        rotary: (n, n) 1/m, of unit rhoI.
    """

    stiffness: Real
    mass: Real
    rotary: Real


def shape_rows(x_m: float | Real, length_m: float) -> Real:
    """Hermite interpolation of the deflection: (points, n) rows N with w(x) = N q; not to be written to."""
    return _known_rows(np.atleast_1d(np.asarray(x_m, dtype=np.float64)).tobytes(), length_m, 0)


def slope_rows(x_m: float | Real, length_m: float) -> Real:
    """Hermite interpolation of the slope: (points, n) rows N with w'(x) = N q; not to be written to."""
    return _known_rows(np.atleast_1d(np.asarray(x_m, dtype=np.float64)).tobytes(), length_m, 1)


def curvature_rows(x_m: float | Real, length_m: float) -> Real:
    """Hermite interpolation of the curvature: (points, n) rows N with w''(x) = N q; not to be written to."""
    return _known_rows(np.atleast_1d(np.asarray(x_m, dtype=np.float64)).tobytes(), length_m, 2)


@lru_cache(maxsize=256)
def _known_rows(places: bytes, length_m: float, derivative: int) -> Real:
    # A fit asks for the same sensors thousands of times.
    rows = _interpolation_rows(np.frombuffer(places), length_m, derivative)
    rows.flags.writeable = False
    return rows


def weakened_stiffness(x_m: float, width_m: float, length_m: float, share: float) -> Real:
    """(n, n) change of the stiffness of unit EI when it falls to 1 - share exp(-((x - x0) / width)^2).

    Cubics can't bend more in a part of an element: its stiffness is the inverse of its flexibility under linear
    moments, which is exact for any EI(x) between two nodes (Przemieniecki, Theory of Matrix Structural Analysis, 5.6).
    """
    size = length_m / ELEMENTS
    first = max(0, int((x_m - 4 * width_m) / size))
    last = min(ELEMENTS, int((x_m + 4 * width_m) / size) + 1)
    nodes, weights = gauss_legendre(12)
    xi = (nodes + 1) / 2
    moment = np.stack([xi - 1, xi])
    chord = np.array([[1 / size, 1, -1 / size, 0], [1 / size, 0, -1 / size, 1]])
    whole = size * np.array([[1 / 3, -1 / 6], [-1 / 6, 1 / 3]])
    matrix = np.zeros((2 * ELEMENTS + 2,) * 2)
    for e in range(first, last):
        at = slice(2 * e, 2 * e + 4)
        left = 1 - share * np.exp(-((((e + xi) * size - x_m) / width_m) ** 2))
        flexibility = size / 2 * np.einsum("q,iq,jq->ij", weights / left, moment, moment)
        matrix[at, at] += chord.T @ (np.linalg.inv(flexibility) - np.linalg.inv(whole)) @ chord
    return matrix


@lru_cache(maxsize=8)
def beam_matrices(length_m: float) -> BeamMatrices:
    """The patterns of a beam of this length."""
    size = length_m / ELEMENTS
    terms = range(FIELD_TERMS + 1)
    n = 2 * ELEMENTS + 2
    stiffness, mass, rotary = np.zeros((len(terms), n, n)), np.zeros((len(terms), n, n)), np.zeros((n, n))
    nodes, weights = gauss_legendre(6)
    xi, weights = (nodes + 1) / 2, weights / 2
    deflection, slope, curvature = (_hermite_cubics(xi, size, d) for d in (0, 1, 2))
    for e in range(ELEMENTS):
        at = slice(2 * e, 2 * e + 4)
        field = np.cos(np.outer(terms, np.pi * (e + xi) / ELEMENTS)) * weights * size
        stiffness[:, at, at] += np.einsum("tq,qi,qj->tij", field, curvature, curvature)
        mass[:, at, at] += np.einsum("tq,qi,qj->tij", field, deflection, deflection)
        rotary[at, at] += np.einsum("q,qi,qj->ij", field[0], slope, slope)
    return BeamMatrices(stiffness, mass, rotary)


@lru_cache(maxsize=8)
def clamped_beam_flexibility(length_m: float) -> Real:
    """(n, n) deflection of a clamped beam of unit EI to unit loads on its degrees of freedom; not to be written to."""
    answer = np.zeros((2 * ELEMENTS + 2,) * 2)
    answer[2:, 2:] = np.linalg.inv(beam_matrices(length_m).stiffness[0][2:, 2:])
    answer.flags.writeable = False
    return answer


def _hermite_cubics(xi: Real, size: float, derivative: int) -> Real:
    """(points, 4) Hermite cubics on [0, 1], differentiated by x."""
    one = np.ones_like(xi)
    if derivative == 0:
        rows = (
            1 - 3 * xi**2 + 2 * xi**3,
            size * (xi - 2 * xi**2 + xi**3),
            3 * xi**2 - 2 * xi**3,
            size * (xi**3 - xi**2),
        )
    elif derivative == 1:
        rows = (-6 * xi + 6 * xi**2, size * (one - 4 * xi + 3 * xi**2), 6 * xi - 6 * xi**2, size * (3 * xi**2 - 2 * xi))
    else:
        rows = (-6 + 12 * xi, size * (-4 + 6 * xi), 6 - 12 * xi, size * (6 * xi - 2))
    return np.stack(rows, axis=-1) / size**derivative


def _interpolation_rows(x: Real, length_m: float, derivative: int) -> Real:
    size = length_m / ELEMENTS
    element = np.clip((x / size).astype(int), 0, ELEMENTS - 1)
    rows = np.zeros((len(x), 2 * ELEMENTS + 2))
    values = _hermite_cubics(x / size - element, size, derivative)
    for i, (e, value) in enumerate(zip(element, values, strict=True)):
        rows[i, 2 * e : 2 * e + 4] = value
    return rows
