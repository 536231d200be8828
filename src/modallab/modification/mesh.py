"""Shapes at the nodes of a computed model: between the points of a rig they are known, not interpolated from them."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.deflection import motion_at_points, rotate_to_real
from modallab.modification.freedoms import freedoms_of, output_signs
from modallab.modification.structure import Structure


@dataclass(frozen=True, eq=False, slots=True)
class Wireframe:
    """Places of a structure, and what joins them.

    Attributes:
        points: (places,) of the rig; 0 for a clamp, which is at rest.
        places_m: (places, 3)
        lines: pairs of places, from 0.
        surfaces: places around a face each.
    """

    points: tuple[int, ...]
    places_m: Real
    lines: tuple[tuple[int, int], ...]
    surfaces: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, rig: Rig) -> "Wireframe":
        """Of a rig; without lines, points are joined in the order of x, from a clamp on."""
        places = [(p.x_m, p.y_m, p.z_m) for p in rig.points]
        points = [p.id for p in rig.points]
        order = {p: n for n, p in enumerate(points)}
        lines = tuple((order[a], order[b]) for a, b in rig.lines)
        if not rig.lines:
            if rig.model == "cantilever":
                places, points = [*places, (0.0, 0.0, 0.0)], [*points, 0]
            lines = tuple(pairwise(sorted(range(len(places)), key=lambda n: places[n][0])))
        surfaces = tuple(tuple(order[n] for n in face) for face in rig.surfaces)
        return cls(tuple(points), np.array(places, np.float64).reshape(-1, 3), lines, surfaces)

    def displaced(self, motion: Complex) -> Complex:
        """(places, 3) of the motion (points of the rig, 3)."""
        rest = np.zeros((len(self.points) - len(motion), 3), np.complex128)
        return np.concatenate([motion, rest])


def motion_of(structure: Structure, rig: Rig, psi: Complex) -> Complex:
    """(modes, places, 3) of shapes (modes, freedoms), as real as a turn of each makes them, largest 1."""
    return _spread_to_points(rig, structure.freedoms, psi)


def motion_without_scale(model: ModalModel, rig: Rig) -> Complex:
    """The same of the outputs alone, of a model without a driving point.

    Raises:
        DataError: an output has no point, or is no channel of the rig.
    """
    shapes = model.operating_shapes if model.shapes is None else model.shapes
    found = model.modal_constants[:, :, 0] if shapes is None else shapes
    return _spread_to_points(rig, freedoms_of(model, rig)[0], np.nan_to_num(found) * output_signs(model, rig))


def _spread_to_points(rig: Rig, freedoms: tuple[tuple[int, str], ...], shapes: Complex) -> Complex:
    skeleton = Wireframe.of(rig)
    found = [skeleton.displaced(motion_at_points(rig, freedoms, rotate_to_real(row))) for row in shapes]
    motion = np.array(found, np.complex128).reshape(len(shapes), len(skeleton.points), 3)
    most = np.abs(motion).max(axis=(1, 2), initial=0.0, keepdims=True)
    return np.asarray(motion / np.where(most > 0, most, 1.0))


MOST = 400
"""Nodes that shapes are taken along from: n of them cost n^3, and modes of a band are smooth."""

NEXT = 8
"""Nodes next to one that show the surface about it."""
THIN = 0.4
"""Spread of these across a surface over their lesser one along it, at most: more is a body, or a sharp bend."""
OFF = 0.25
"""Of the reach: the surface is off its tangent by more, so that a straight move would leave it."""
LINE = 0.1
"""Lesser spread along a surface over the larger one, at least: less is a line of nodes."""
LEVEL = 0.5
"""Share of a motion along the surface from which nothing is moved in that direction."""


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """Where a model has nodes, and how they move.

    Attributes:
        places_m: (nodes, 3), in the coordinates of the rig.
        motion: axis -> (nodes, modes) at unit modal mass, kg^-1/2; positive along the axis, or along the drive where it
            is its axis. Of the modes of the modal model, in their order and with one sign each for all axes.
    """

    places_m: Real
    motion: Mapping[str, Real]

    def near_points(self, points_m: Real) -> "Mesh":
        """The same at the nodes that tell most about the surroundings of the points (points, 3); at most so many.

        Those next to the points come first, then one after the other the one farthest from all that were taken.
        """
        near = _next_to(self.places_m, points_m)
        away = np.linalg.norm(self.places_m[:, None] - self.places_m[near][None], axis=2).min(axis=1)
        reach = 2 * median_spacing(points_m)
        within = np.linalg.norm(self.places_m[:, None] - points_m[None], axis=2).min(axis=1) <= reach
        away[~within] = 0.0
        taken = list(near)
        while len(taken) < MOST and away.max() > 0:
            farthest = int(np.argmax(away))
            taken.append(farthest)
            away = np.minimum(away, np.linalg.norm(self.places_m - self.places_m[farthest], axis=1))
        return Mesh(self.places_m[taken], {axis: values[taken] for axis, values in self.motion.items()})


def surface_directions(places_m: Real, here_m: Real, axis: str, reach_m: float) -> Real | None:
    """(2, 3) unit vectors along the surface on which the nodes next to a place lie, across a motion along an axis.

    One is 0 where the motion itself is along the surface, or where the surface bends away within reach: off it nothing
    is known. None where the nodes show no surface: they fill a body, or stand in a line.
    """
    away = np.linalg.norm(places_m - here_m, axis=1)
    # All nodes of one distance, or none: else the plane leans towards those that were taken.
    near = away <= np.sort(away)[min(NEXT, away.size - 1)] * (1 + 1e-6)
    around = places_m[near] - here_m
    _, spread, axes = np.linalg.svd(around, full_matrices=False)
    if spread.size < 3 or spread[1] <= LINE * spread[0] or spread[2] > THIN * spread[1]:
        return None
    plane = axes[:2]
    along = plane[:, "xyz".index(axis)]
    size = float(np.linalg.norm(along))
    flat = np.eye(2) if size < LEVEL else np.array([[-along[1], along[0]], [0.0, 0.0]]) / size
    bends = _surface_bending(around @ plane.T, around @ axes[2])
    off = np.abs(np.einsum("ti,ij,tj->t", flat, bends, flat)) * reach_m**2
    found = (flat * (off <= OFF * reach_m)[:, None]) @ plane
    largest = found[np.arange(2), np.argmax(np.abs(found), axis=1)]
    return found * np.where(largest < 0, -1.0, 1.0)[:, None]


def _surface_bending(flat_m: Real, off_m: Real) -> Real:
    """(2, 2) form whose value at a place (2,) in the tangent plane is by how much the surface is off it, m."""
    x, y = flat_m.T
    a, b, c = np.linalg.lstsq(np.stack([x * x, y * y, 2 * x * y], axis=1), off_m, rcond=None)[0]
    return np.array([[a, c], [c, b]])


def _next_to(places_m: Real, points_m: Real) -> list[int]:
    away = np.linalg.norm(points_m[:, None] - places_m[None], axis=2)
    return list(dict.fromkeys(np.argmin(away, axis=1).tolist()))


def median_spacing(points_m: Real) -> float:
    """Median distance from a point to the nearest other, m; 0 of one place alone."""
    places = np.unique(points_m, axis=0)
    if len(places) == 1:
        return 0.0
    away = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(away, np.inf)
    return float(np.median(away.min(axis=1)))
