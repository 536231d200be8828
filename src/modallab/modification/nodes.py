"""Where each mode moves most and where it hardly moves: where to hit, where to mount.

The point whose least motion over all modes is largest is the best for a single hit or sensor, as no mode has a node
there (the non-optimum driving point parameter: Imamovic, PhD thesis, Imperial College London, 1998, ch. 6).
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.freedoms import Freedom
from modallab.modification.shapes import shapes_of
from modallab.modification.structure import Structure

NEAR_NODE = 0.1
"""Of a mode's largest motion: a point with less is near a node."""
STRAIGHT = 1e-6
"""Of the length: points that lie no further beside a line are on it."""
FINE = 400
"""Places along a line of points."""


@dataclass(frozen=True, eq=False, slots=True)
class NodeOnLine:
    """A node between points that lie along a line.

    Attributes:
        mode: from 0.
        place_m: (3,) where it is.
        sigma_m: one standard deviation along the line.
    """

    mode: int
    place_m: Real
    sigma_m: float


@dataclass(frozen=True, eq=False, slots=True)
class AntinodesAndNodes:
    """How much each freedom moves in each mode.

    Attributes:
        frequency_hz: (modes,)
        freedoms: (freedoms,) point and axis.
        motion: (modes, freedoms) over the largest of the mode.
        motion_sigma: (modes, freedoms) one standard deviation.
        crossings: nodes between points along a line; none where the points do not lie along one.
    """

    frequency_hz: Real
    freedoms: tuple[Freedom, ...]
    motion: Real
    motion_sigma: Real
    crossings: tuple[NodeOnLine, ...]

    @property
    def antinode(self) -> tuple[Freedom, ...]:
        """(modes,) where each moves most."""
        return tuple(self.freedoms[n] for n in np.argmax(self.motion, axis=1))

    @property
    def nodes(self) -> tuple[tuple[Freedom, ...], ...]:
        """(modes,) the points near a node of each."""
        return tuple(tuple(f for f, m in zip(self.freedoms, row, strict=True) if m < NEAR_NODE) for row in self.motion)

    @property
    def best_freedom(self) -> tuple[Freedom, float]:
        """The freedom at which the mode that moves least still moves most, and that motion."""
        least = self.motion.min(axis=0)
        n = int(np.argmax(least))
        return self.freedoms[n], float(least[n])


def places_of_modes(structure: Structure, samples: Structure, model: ModalModel, rig: Rig | None) -> AntinodesAndNodes:
    """Where each mode moves, and where not.

    Args:
        structure: as the model has it.
        samples: (samples, ...) of it, for the deviation.
        model: the structure's.
        rig: where the points are; without it there are no nodes between points.
    """
    motion, varied = (_over_largest(np.abs(s.psi)) for s in (structure, samples))
    crossings = () if rig is None else tuple(_nodes_on_line(structure, samples, model, rig))
    hz = np.asarray(np.abs(structure.poles) / (2 * np.pi))
    return AntinodesAndNodes(hz, structure.freedoms, motion, np.std(varied, axis=0), crossings)


def _over_largest(size: Real) -> Real:
    return size / size.max(axis=-1, keepdims=True)


def _nodes_on_line(structure: Structure, samples: Structure, model: ModalModel, rig: Rig) -> list[NodeOnLine]:
    shapes = shapes_of(model, rig)
    here = np.array([f[1] == structure.drive_axis for f in structure.freedoms])
    known = shapes.at_m[here]
    if len(known) < 3 or not _on_a_line(known):
        return []
    along = known - known[0]
    ends = known[[np.argmin(along @ _direction_of_line(known)), np.argmax(along @ _direction_of_line(known))]]
    places = ends[0] + np.linspace(0, 1, FINE)[:, None] * (ends[1] - ends[0])
    between = shapes.between[structure.drive_axis]
    through, unsure = between.interpolation_matrix(places), between.uncertainty(places)
    # At unit modal mass, as those between which is taken along.
    scale = np.sqrt(2 * structure.poles.imag)[:, None]
    motion = (_real_shapes(scale * s.psi[..., here]) for s in (structure, samples))
    values, varied = (np.einsum("mpk,...mk->...pm", through, of) for of in motion)
    step = float(np.linalg.norm(places[1] - places[0]))
    found: list[NodeOnLine] = []
    for mode in range(len(structure.poles)):
        y = values[:, mode]
        for n in np.flatnonzero(y[:-1] * y[1:] < 0):
            share = y[n] / (y[n] - y[n + 1])
            slope = abs(y[n + 1] - y[n]) / step
            place = places[n] + share * (places[n + 1] - places[n])
            spread = np.std((1 - share) * varied[:, n, mode] + share * varied[:, n + 1, mode])
            found.append(NodeOnLine(mode, place, float(np.hypot(spread, unsure[n, mode]) / slope)))
    return found


def _on_a_line(places: Real) -> bool:
    size = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(size[0] > 0 and size[1] < STRAIGHT * size[0])


def _direction_of_line(places: Real) -> Real:
    return np.linalg.svd(places - places.mean(axis=0))[2][0]


def _real_shapes(psi: Complex) -> Real:
    """Shapes turned in phase until their imaginary parts are least; of one sign at the largest component."""
    turned = psi * np.exp(-0.5j * np.angle(np.sum(psi**2, axis=-1, keepdims=True)))
    largest = np.argmax(np.abs(turned), axis=-1)[..., None]
    return np.real(turned) * np.sign(np.real(np.take_along_axis(turned, largest, axis=-1)))
