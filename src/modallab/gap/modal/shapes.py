"""Mode shapes at unit modal mass at every measured freedom, and between them.

A modal constant is the product of the shape at the output and at the input, so that a roving hammer shows the shape at
every point it strikes and a roving sensor at every point it stands. Between the points the shapes of one direction
are taken along by radial functions r^5 with a quadratic part, which bend no border straight as r^3 does (Wendland,
Scattered Data Approximation, 2005, ch. 8).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.mesh import Mesh, apart, on_surface

Real = NDArray[np.float64]
Freedom = tuple[int, str]
"""A point and the axis of motion there: x, y or z; positive along the axis, or along the drive where it is its axis."""

NEIGHBOURS = 8
FLAT = 0.5
"""A direction in which a point's neighbours spread less than this share of their widest is not resolved."""


@dataclass(frozen=True, eq=False, slots=True)
class Shapes:
    """Shapes of all freedoms.

    Attributes:
        freedoms: (freedoms,) that are known.
        at_m: (freedoms, 3) where they are.
        psi: (modes, freedoms) at unit modal mass, kg^-1/2.
        between: axis -> its shapes between the points.
        surface: (2, 3) tangents at the freedoms where a mesh shows its surface.
    """

    freedoms: tuple[Freedom, ...]
    at_m: Real
    psi: Real
    between: Mapping[str, "Between"]
    surface: Mapping[Freedom, Real] = field(default_factory=dict[Freedom, Real])

    @classmethod
    def of(cls, freedoms: tuple[Freedom, ...], at_m: Real, psi: Real, mesh: Mesh | None = None) -> "Shapes":
        """With what lies between: through the nodes of a mesh, else through the freedoms themselves."""
        same = {axis: np.array([f[1] == axis for f in freedoms]) for _, axis in freedoms}
        if mesh is None or not set(same) <= set(mesh.motion):
            return cls(freedoms, at_m, psi, {a: Between.of(at_m[s], psi[:, s].T) for a, s in same.items()})
        known = mesh.about(at_m)
        between = {a: Between.of(known.places_m, known.motion[a]) for a in same}
        # A shape's sign is free: that of the mesh follows the one of the modal constants.
        together = sum(np.sum(between[a].at(at_m[s]) * psi[:, s].T, axis=0) for a, s in same.items())
        sign = np.where(np.asarray(together) < 0, -1.0, 1.0)
        turned = {a: replace(b, weights=b.weights * sign) for a, b in between.items()}
        reach = apart(at_m)
        shown = {f: on_surface(mesh.places_m, at, f[1], reach) for f, at in zip(freedoms, at_m, strict=True)}
        return cls(freedoms, at_m, psi, turned, {f: t for f, t in shown.items() if t is not None})

    def index(self, freedom: Freedom) -> int:
        """Place of a freedom."""
        return self.freedoms.index(freedom)

    def tangents(self, freedom: Freedom) -> Real:
        """(2, 3) two unit vectors along the surface at a freedom, across its motion; 0 where the points show none."""
        if freedom in self.surface:
            return self.surface[freedom]
        here = self.at_m[self.index(freedom)]
        same = np.array([f[1] == freedom[1] for f in self.freedoms])
        away = self.at_m[same] - here
        away[:, "xyz".index(freedom[1])] = 0.0
        near = np.argsort(np.linalg.norm(away, axis=1))[: NEIGHBOURS + 1]
        _, spread, axes = np.linalg.svd(away[near], full_matrices=False)
        found = np.zeros((2, 3))
        for n, (size, axis) in enumerate(zip(spread[:2], axes[:2], strict=False)):
            if spread[0] > 0 and size > FLAT * spread[0]:
                found[n] = axis * np.sign(axis[np.argmax(np.abs(axis))])
        return found

    def moved(self, freedom: Freedom, offsets_m: Real) -> Real:
        """(offsets, modes) the shapes at places (offsets, 3) away from a freedom, motion along the same axis."""
        return self.between[freedom[1]].at(self.at_m[self.index(freedom)] + offsets_m)

    def uncertain(self, freedom: Freedom, offsets_m: Real) -> Real:
        """(offsets, modes) by how much `moved` may be off there, one deviation; nothing at a point."""
        return self.between[freedom[1]].spread(self.at_m[self.index(freedom)] + offsets_m)

    def slopes(self, freedom: Freedom) -> Real:
        """(2, modes) derivatives along the tangents, 1/m."""
        tangents = self.tangents(freedom)
        step = 1e-3 * float(np.ptp(self.at_m, axis=0).max())
        both = self.moved(freedom, np.concatenate([step * tangents, -step * tangents]))
        return (both[:2] - both[2:]) / (2 * step)


def shapes_of(model: ModalModel, rig: Rig, mesh: Mesh | None = None) -> Shapes:
    """The shapes that a model's constants hold, and between the points those of a mesh where there is one.

    Raises:
        DataError: an output or input has no point, or no sensor along the drive stands at a driven point, so that
            no shape has a scale.
    """
    outputs, inputs, signs = freedoms_of(model, rig)
    listed = tuple(dict.fromkeys([*outputs, *inputs]))
    if not set(outputs) & set(inputs):
        raise DataError(
            "no sensor stands at a driven point and along the drive: the shapes have no scale",
            where=rig.name,
            remedy="strike once where a sensor stands, in its direction",
        )
    constants = np.real(model.modal_constants) * signs[:, None]
    rows, columns = [listed.index(f) for f in outputs], [listed.index(f) for f in inputs]
    psi = np.array([_rank_one(a, rows, columns, len(listed)) for a in constants])
    points = {p.id: (p.x_m, p.y_m, p.z_m) for p in rig.points}
    return Shapes.of(listed, np.array([points[f[0]] for f in listed]), psi, mesh)


def freedoms_of(model: ModalModel, rig: Rig) -> tuple[list[Freedom], list[Freedom], Real]:
    """Freedoms of outputs and inputs, and (outputs,) sign of a reading over the motion along the freedom.

    Raises:
        DataError: a point is not known.
    """
    drive = rig.drive_direction[1]
    by_name = {c.name: c for c in rig.channels}
    if None in model.output_points or None in model.input_points:
        raise DataError(
            "an output or an input has no point", where=rig.name, remedy="give channels and records their points"
        )
    axes = [by_name[name].direction for name in model.outputs]
    outputs = [(int(p or 0), axis[1]) for p, axis in zip(model.output_points, axes, strict=True)]
    inputs = [(int(p or 0), drive) for p in model.input_points]
    # What reads along the drive has been turned to its sense already.
    signs = np.array([1.0 if axis[1] == drive or axis[0] == "+" else -1.0 for axis in axes])
    return outputs, inputs, signs


def _rank_one(constants: Real, rows: Sequence[int], columns: Sequence[int], n: int) -> Real:
    """(n,) shape whose products are the constants, by alternating least squares from the largest singular pair."""
    left, size, right = np.linalg.svd(constants, full_matrices=False)
    u, v = left[:, 0] * np.sqrt(size[0]), right[0] * np.sqrt(size[0])
    own = {f: u[i] for i, f in enumerate(rows)}
    shared = [(own[f], v[k]) for k, f in enumerate(columns) if f in own]
    # u is the shape times a factor, v the shape over it; where both are known their ratio is its square.
    over, under = sum(a * a for a, _ in shared), sum(a * b for a, b in shared)
    factor = np.sqrt(abs(under) / over) if over > 0 else 1.0
    psi = np.zeros(n)
    psi[list(rows)] = u * factor
    psi[list(columns)] = v / factor
    for _ in range(30):
        psi = _improved(psi, constants, rows, columns)
    return psi


def _improved(psi: Real, constants: Real, rows: Sequence[int], columns: Sequence[int]) -> Real:
    at, of = psi[list(rows)], psi[list(columns)]
    n = psi.size
    left = (constants - np.outer(at, of)).ravel()
    design = np.zeros((left.size, n))
    cells = np.arange(left.size)
    np.add.at(design, (cells, np.repeat(rows, len(columns))), np.tile(of, len(rows)))
    np.add.at(design, (cells, np.tile(columns, len(rows))), np.repeat(at, len(columns)))
    normal, right = design.T @ design, design.T @ left
    normal += 1e-9 * np.trace(normal) / n * np.eye(n)
    return psi + np.linalg.solve(normal, right)


@dataclass(frozen=True, eq=False, slots=True)
class Between:
    """Values taken along in space.

    Attributes:
        known: (known, 3) places, centred and scaled.
        weights: (known + 10, columns) of the radial functions and the quadratic part.
        inverse: (known + 10, known + 10) of the system that gives the weights.
        rough: (columns,) deviation of the functions that go through such values, in the units of the kernel.
        middle: (3,) of the places, m.
        size: their extent, m.
    """

    known: Real
    weights: Real
    inverse: Real
    rough: Real
    middle: Real
    size: float

    @classmethod
    def of(cls, known_m: Real, values: Real) -> "Between":
        """Through values (known, columns) at places (known, 3)."""
        middle, size = known_m.mean(axis=0), max(float(np.ptp(known_m, axis=0).max()), 1e-9)
        known = (known_m - middle) / size
        part = _quadratic(known)
        terms = part.shape[1]
        whole = np.block([[_radial(known, known), part], [part.T, np.zeros((terms, terms))]])
        # Points in one plane, or few, leave coefficients of the quadratic part open: the smallest do.
        inverse = np.asarray(np.linalg.pinv(whole, rcond=1e-12), np.float64)
        weights = inverse @ np.concatenate([values, np.zeros((terms, values.shape[1]))])
        # -r^5 is the covariance of what the quadratic part leaves.
        power = -np.sum(values * weights[: len(known)], axis=0)
        free = max(len(known) - int(np.linalg.matrix_rank(part)), 1)
        return cls(known, weights, inverse, np.sqrt(np.maximum(power, 0.0) / free), middle, size)

    def at(self, places_m: Real) -> Real:
        """(places, columns) at places (places, 3)."""
        places = (places_m - self.middle) / self.size
        return self._terms(places) @ self.weights

    def spread(self, places_m: Real) -> Real:
        """(places, columns) deviation of the values there: that of kriging, whose scale is how rough the values are."""
        terms = self._terms((places_m - self.middle) / self.size)
        square = np.einsum("pi,ij,pj->p", terms, self.inverse, terms)
        return np.sqrt(np.maximum(square, 0.0))[:, None] * self.rough

    def _terms(self, places: Real) -> Real:
        return np.concatenate([_radial(places, self.known), _quadratic(places)], axis=1)


def _radial(p: Real, q: Real) -> Real:
    return np.linalg.norm(p[:, None] - q[None], axis=2) ** 5


def _quadratic(p: Real) -> Real:
    i, j = np.triu_indices(3)
    return np.concatenate([np.ones((len(p), 1)), p, p[:, i] * p[:, j]], axis=1)
