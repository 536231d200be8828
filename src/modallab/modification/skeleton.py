"""A structure as points with lines between them, and how they move."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.deflection import motion_at_points, turn_to_real
from modallab.modification.freedoms import freedoms_of, senses_of
from modallab.modification.structure import Structure


@dataclass(frozen=True, eq=False, slots=True)
class Skeleton:
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
    def of(cls, rig: Rig) -> "Skeleton":
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

    def moved(self, motion: Complex) -> Complex:
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
    return _spread_to_points(rig, freedoms_of(model, rig)[0], np.nan_to_num(found) * senses_of(model, rig))


def _spread_to_points(rig: Rig, freedoms: tuple[tuple[int, str], ...], shapes: Complex) -> Complex:
    skeleton = Skeleton.of(rig)
    found = [skeleton.moved(motion_at_points(rig, freedoms, turn_to_real(row))) for row in shapes]
    motion = np.array(found, np.complex128).reshape(len(shapes), len(skeleton.points), 3)
    most = np.abs(motion).max(axis=(1, 2), initial=0.0, keepdims=True)
    return np.asarray(motion / np.where(most > 0, most, 1.0))
