"""The beam as a chain of links with the twin's own modes, for simulations of rigid bodies.

A chain of hinges alone has the frequencies of a beam only in the limit of many links. Here the masses at the nodes are
chosen so that the beam's shapes, taken at the nodes, are orthonormal over them (a quadrature for products of shapes;
non-negative least squares: Lawson and Hanson, Solving Least Squares Problems, 1974, ch. 23); and its stiffness and
damping act on combinations of hinges, one for each mode, so that frequencies and damping ratios are the twin's exactly.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from modallab.core.arrays import Real
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure

LINKS = 20
"""Least number of links. There is a node at each point that is driven or measured."""
CLOSE = 0.3
"""Of a link's length: nodes nearer than that to a point make room for it."""
LEAST_MASS = 1e-3
"""Of the mean mass of a node, which none may lack."""
OTHERS = 1.3
"""Frequency of all that is no mode of the twin, over that of its highest."""
OTHERS_ZETA = 0.05


@dataclass(frozen=True, eq=False, slots=True)
class JointedChain:
    """A chain along x whose nodes move along z.

    Attributes:
        nodes_m: (n + 1,) places of the nodes, the clamp first.
        masses_kg: (n + 1,) at the nodes; at the clamp only where it gives way.
        slides: whether the clamp gives way along z, as the first joint.
        modes: (n joints, m) shapes in the joints' coordinates.
        omega: (m,) rad/s.
        zeta: (m,) damping ratios.
        dampers: (joints,) what a damper to ground feels of each joint, and its N s/m.
    """

    nodes_m: Real
    masses_kg: Real
    slides: bool
    modes: Real
    omega: Real
    zeta: Real
    dampers: tuple[tuple[Real, float], ...]

    @property
    def displacement(self) -> Real:
        """(nodes, joints) what each node moves by each joint; of links only, not of the slide."""
        return _joint_displacements(self.nodes_m, self.slides)


def chain_of_structure(structure: TwinStructure, places_m: Real) -> JointedChain:
    """The chain of a structure, with nodes at these places."""
    modes = solve_modes(replace(structure, dampers=()))
    omega, zeta = np.abs(modes.poles), -modes.poles.real / np.abs(modes.poles)
    nodes = _chain_nodes(structure.length_m, places_m)
    # Undamped shapes at unit modal mass: those of the poles but for the factor of their scale.
    scale = np.sqrt(2j * modes.poles.imag)
    shapes = np.asarray(np.real(modes.shapes_at(nodes) * scale), dtype=np.float64)
    slides = bool(structure.root_translation)
    masses = _lumped_masses(shapes, structure)
    moved = _joint_displacements(nodes, slides)
    used = nodes > 0 if not slides else np.ones(len(nodes), dtype=np.bool_)
    joints = np.asarray(np.linalg.lstsq(moved[used], shapes[used], rcond=None)[0], dtype=np.float64)
    dampers = tuple((_row_at(x, nodes, moved), c) for x, c in structure.dampers if c)
    return JointedChain(nodes, masses, slides, joints, omega, zeta, dampers)


def _chain_nodes(length_m: float, places_m: Real) -> Real:
    fixed = np.unique(np.round(np.concatenate([[0.0, length_m], places_m]), 9))
    step = length_m / LINKS
    grid = np.linspace(0.0, length_m, LINKS + 1)
    room = np.min(np.abs(grid[:, None] - fixed), axis=1) > CLOSE * step
    return np.asarray(np.sort(np.concatenate([fixed, grid[room]])), dtype=np.float64)


def _lumped_masses(shapes: Real, structure: TwinStructure) -> Real:
    count = shapes.shape[1]
    first, second = np.triu_indices(count)
    # What the low modes need counts most: the band lies there.
    weight = 1.0 / (1.0 + np.maximum(first, second)) ** 5
    products = (shapes[:, first] * shapes[:, second]).T
    wanted = (first == second).astype(np.float64)
    mean = structure.mass_per_length * structure.length_m / len(shapes)
    found, _ = nnls(products * weight[:, None], wanted * weight, maxiter=100 * len(shapes))
    return np.maximum(found, LEAST_MASS * mean)


def _joint_displacements(nodes_m: Real, slides: bool) -> Real:
    hinges = np.maximum(nodes_m[:, None] - nodes_m[None, :-1], 0.0)
    return np.hstack([np.ones((len(nodes_m), 1)), hinges]) if slides else hinges


def _row_at(x_m: float, nodes_m: Real, moved: Real) -> Real:
    return np.array([np.interp(x_m, nodes_m, column) for column in moved.T])


def joint_combinations(found: JointedChain, mass: Real) -> list[tuple[Real, float, float]]:
    """Combinations of joints with their stiffness and damping, for joints with this mass matrix (joints, joints).

    With M-orthonormal shapes theta_r, stiffness sum_r omega_r^2 (M theta_r)(M theta_r)^T has them as its modes.
    """
    theta = mass_orthonormal(found.modes, mass)
    whole = np.hstack([theta, _complement_shapes(theta, mass)])
    rest = whole.shape[1] - len(found.omega)
    omega = np.concatenate([found.omega, np.full(rest, OTHERS * float(found.omega.max()))])
    zeta = np.concatenate([found.zeta, np.full(rest, OTHERS_ZETA)])
    springs: list[tuple[Real, float, float]] = [
        (mass @ shape, float(w**2), float(2 * z * w)) for shape, w, z in zip(whole.T, omega, zeta, strict=True)
    ]
    return springs + [(row, 0.0, c) for row, c in found.dampers]


def mass_orthonormal(shapes: Real, mass: Real) -> Real:
    """The shapes, each made orthonormal to those before: the low modes stay as they are (Gram and Schmidt)."""
    lower: NDArray[Any] = np.linalg.cholesky(shapes.T @ mass @ shapes)
    return np.asarray(np.linalg.solve(lower, shapes.T), dtype=np.float64).T


def _complement_shapes(theta: Real, mass: Real) -> Real:
    """M-orthonormal shapes of all else."""
    lower: NDArray[Any] = np.linalg.cholesky(mass)
    known = lower.T @ theta
    q, _ = np.linalg.qr(np.hstack([known, np.eye(len(mass))]))
    return np.asarray(np.linalg.solve(lower.T, q[:, theta.shape[1] : len(mass)]), dtype=np.float64)
