"""A sine test that looks for the decays of the modes the impact test before it has found."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.core.arrays import Real
from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel
from modallab.core.plan import KnownMode, Plan, Precision, SinePlan
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.identification.model.modal_mass import driving_points


def with_modes(plan: SinePlan, model: ModalModel) -> SinePlan:
    """The plan, with the modes of a model as those whose decays are looked for."""
    pairs = zip(model.frequency_hz, model.damping_ratio, strict=True)
    known = tuple(KnownMode(frequency_hz=float(f), damping_ratio=float(z)) for f, z in pairs if 0 < z < 1)
    return plan.model_copy(update={"modes": known})


def with_known_modes(plan: Plan, recorded: Callable[[], Campaign]) -> Plan:
    """The plan, with the modes of the impact test that was recorded before it, if it needs them.

    Args:
        plan: needs them if it lengthens bursts until they have settled (`max_settle_s`), and names no modes itself.
        recorded: what was recorded so far in this session; read only if needed.

    Returns:
        The plan as it was where it needs none, or no impact test gave a model; the test itself then rejects a
        `max_settle_s` that nothing decides on.
    """
    if not isinstance(plan, SinePlan) or plan.max_settle_s is None or plan.modes:
        return plan
    # Not above: few plans need it, and every process that records loads this module.
    from modallab.identification.options import IdentificationOptions
    from modallab.pipelines.identify import identify_campaign

    try:
        result = identify_campaign(recorded(), IdentificationOptions(), "impact")
    except ModallabError:
        return plan
    return with_modes(plan, result.identified[0].model)


def expected_modes(rig: Rig) -> ExpectedModes | None:
    """The modes of the rig's beam at its points and sensors; None where the rig file describes no beam or no sensor."""
    sensors = [
        c
        for c in rig.responses
        if c.quantity in DERIVATIVE and c.point is not None and c.direction[1] == rig.drive_direction[1]
    ]
    if rig.beam is None or rig.model != "cantilever" or not sensors or not rig.points:
        return None
    # Not above: whoever records loads this module, and the twin loads SciPy.
    from modallab.twin.modes import solve_modes
    from modallab.twin.structure import TwinStructure

    modes = solve_modes(TwinStructure.of(rig.beam, rig.damping_ratio.guess))
    unit_mass = np.sqrt(2j * modes.poles.imag)

    def shapes(points: Sequence[int]) -> NDArray[np.float64]:
        return (modes.at(np.array([rig.x_of(point) for point in points])) * unit_mass).real.astype(np.float64)

    return ExpectedModes(
        frequency_hz=modes.frequency_hz,
        damping_ratio=rig.damping_ratio.guess,
        points=tuple(p.id for p in rig.points),
        at_points=shapes([p.id for p in rig.points]),
        channels=tuple(c.index for c in sensors),
        at_sensors=shapes([c.point for c in sensors if c.point is not None]),
        derivative=np.array([DERIVATIVE[c.quantity] for c in sensors], dtype=np.int64),
    )


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
