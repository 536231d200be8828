"""The point at which one more hit would tell most of the modes that are known least."""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.model import ModalModel
from modallab.core.plan import Precision
from modallab.core.rig import Rig
from modallab.identification.model.modal_mass import driving_points


def most_informative_point(model: ModalModel, rig: Rig, hits: dict[int, int], target: Precision) -> int | None:
    """The point where one more hit brings the worst known mode nearest to its target; None where no point is known.

    What a hit tells of a mode goes with the square of the mode's shape at its point, whatever the sensors. The shapes
    are those at points that were struck and, where one of these has a sensor along the drive, at all that have such a
    sensor: by reciprocity what moves at a point is moved from there.

    Args:
        model: of the hits so far, with its sigmas.
        rig: that it was measured on.
        hits: good ones by point.
        target: how well the modes are to be known.
    """
    shapes = _square_shapes(model, rig)
    known = sum(count * shapes[point] for point, count in hits.items() if point in shapes)
    if not shapes or not np.all(known):
        return None
    worst = {
        point: float(np.max(_sigma_over_target(model, target) / np.sqrt(1 + own / known)))
        for point, own in shapes.items()
    }
    # Of points alike in that, the one that tells most of all modes together.
    return min(shapes, key=lambda p: (round(worst[p], 6), -float(np.sum(np.log1p(shapes[p] / known)))))


def _sigma_over_target(model: ModalModel, target: Precision) -> Real:
    """(modes,) sigma over its target, of frequency or damping, whichever is farther from it."""
    frequency = model.frequency_sigma_hz / model.frequency_hz / target.frequency_ratio
    return np.maximum(frequency, model.damping_sigma / model.damping_ratio / target.damping_ratio)


def _square_shapes(model: ModalModel, rig: Rig) -> dict[int, Real]:
    """Point -> (modes,) square of the shape there, in a unit of each mode's own."""
    squares = np.abs(model.modal_constants) ** 2
    struck = squares.sum(axis=1)
    found = {point: struck[:, k] for k, point in enumerate(model.input_points) if point is not None}
    along = dict(zip((c.name for c in rig.responses), driving_points(rig), strict=True))
    at = {along.get(name): o for o, name in enumerate(model.outputs) if along.get(name) is not None}
    shared = [(o, found[p]) for p, o in at.items() if p in found]
    if not shared:
        return found
    moved = squares.sum(axis=2)
    # Both say the shape at a driving point; the sum over several is kinder to one that stands in a node.
    scale = sum(own for _, own in shared) / np.maximum(sum(moved[:, o] for o, _ in shared), np.finfo(float).tiny)
    return {p: moved[:, o] * scale for p, o in at.items() if p is not None} | found
