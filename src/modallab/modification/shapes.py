"""Mode shapes at unit modal mass at every measured freedom, and between them.

A modal constant is the product of the shape at the output and at the input, so that a roving hammer shows the shape at
every point it strikes and a roving sensor at every point it stands. Shapes are complex, as the modal constants are:
what a sensor shows of a freedom, and what a force there does, stay two numbers where both were measured.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.freedoms import Freedom, ModalFactors, factor_constants, freedoms_of
from modallab.modification.interpolation import ROUGH, SpatialInterpolation
from modallab.modification.mesh import Mesh, median_spacing, surface_directions

NEIGHBOURS = 8
FLAT = 1e-3
"""Neighbours that spread less across than this share of their widest stand in a line: nothing shows what is beside."""


@dataclass(frozen=True, eq=False, slots=True)
class FreedomShapes:
    """Shapes of all freedoms.

    Attributes:
        freedoms: (freedoms,) that are known.
        at_m: (freedoms, 3) where they are.
        seen: (modes, freedoms) as sensors show them, kg^-1/2 at unit modal mass if there is a scale.
        driven: (modes, freedoms) as forces there excite them, without the phase of the chain.
        turn: factor exp(j phase) of the chain, which all modal constants have in common.
        scaled: whether a sensor stands at a driven point, so that the modal mass is known.
        between: axis -> its shapes between the points.
        surface: (2, 3) tangents at the freedoms where a mesh shows its surface.
    """

    freedoms: tuple[Freedom, ...]
    at_m: Real
    seen: Complex
    driven: Complex
    turn: complex
    scaled: bool
    between: Mapping[str, SpatialInterpolation]
    surface: Mapping[Freedom, Real] = field(default_factory=dict[Freedom, Real])

    @classmethod
    def of(
        cls, freedoms: tuple[Freedom, ...], at_m: Real, factors: ModalFactors, mesh: Mesh | None = None
    ) -> "FreedomShapes":
        """With what lies between: through the nodes of a mesh, else through the freedoms themselves."""
        known = (freedoms, at_m, factors.seen, factors.driven, factors.turn, factors.scaled)
        both = (factors.seen + factors.driven) / 2
        same = {axis: np.array([f[1] == axis for f in freedoms]) for _, axis in freedoms}
        if mesh is None or not set(same) <= set(mesh.motion):
            return cls(*known, {a: SpatialInterpolation.of(at_m[s], both[:, s].T) for a, s in same.items()})
        near = mesh.near_points(at_m)
        between = {a: SpatialInterpolation.of(near.places_m, near.motion[a], ROUGH[:1]) for a in same}
        # A shape's sign is free: that of the mesh follows the one of the modal constants.
        together = sum(np.sum(np.conj(between[a].at(at_m[s])) * both[:, s].T, axis=0) for a, s in same.items())
        turned = {a: b.rotated_phase(_unit_sizes(np.asarray(together))) for a, b in between.items()}
        reach = median_spacing(at_m)
        shown = {f: surface_directions(mesh.places_m, at, f[1], reach) for f, at in zip(freedoms, at_m, strict=True)}
        return cls(*known, turned, {f: t for f, t in shown.items() if t is not None})

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

    def shapes_beside(self, freedom: Freedom, offsets_m: Real) -> Complex:
        """(offsets, modes) the shapes at places (offsets, 3) away from a freedom, motion along the same axis."""
        return np.asarray(self.between[freedom[1]].at(self.at_m[self.index(freedom)] + offsets_m), np.complex128)

    def uncertainty_beside(self, freedom: Freedom, offsets_m: Real) -> Real:
        """(offsets, modes) by how much shapes may differ otherwise from those at the freedom, one deviation."""
        here = self.at_m[self.index(freedom)]
        return self.between[freedom[1]].uncertainty(here + offsets_m, here)

    def slopes(self, freedom: Freedom) -> Complex:
        """(2, modes) derivatives along the tangents, 1/m."""
        tangents = self.tangents(freedom)
        # Of one place alone no tangent is known, and any step shows nothing.
        step = 1e-3 * (float(np.ptp(self.at_m, axis=0).max()) or 1.0)
        both = self.shapes_beside(freedom, np.concatenate([step * tangents, -step * tangents]))
        return (both[:2] - both[2:]) / (2 * step)


def _unit_sizes(values: Complex) -> Complex:
    """Each over its size; 1 where it is 0."""
    size = np.abs(values)
    return np.asarray(np.where(size > 0, values, 1.0) / np.where(size > 0, size, 1.0), np.complex128)


def shapes_of(model: ModalModel, rig: Rig, mesh: Mesh | None = None) -> FreedomShapes:
    """The shapes that a model's constants hold, along its freedoms; between the points those of a mesh, if any.

    Raises:
        DataError: an output or input has no point.
    """
    outputs, inputs = freedoms_of(model, rig)
    listed = tuple(dict.fromkeys([*outputs, *inputs]))
    rows, columns = [listed.index(f) for f in outputs], [listed.index(f) for f in inputs]
    factors = factor_constants(model.modal_constants, rows, columns, len(listed))
    points = {p.id: (p.x_m, p.y_m, p.z_m) for p in rig.points}
    return FreedomShapes.of(listed, np.array([points[f[0]] for f in listed]), factors, mesh)
