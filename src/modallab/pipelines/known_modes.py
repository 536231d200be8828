"""A sine test that looks for the decays of the modes the impact test before it has found."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel
from modallab.core.plan import KnownMode, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE


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
        return (modes.shapes_at(np.array([rig.x_of(point) for point in points])) * unit_mass).real.astype(np.float64)

    return ExpectedModes(
        frequency_hz=modes.frequency_hz,
        damping_ratio=rig.damping_ratio.guess,
        points=tuple(p.id for p in rig.points),
        at_points=shapes([p.id for p in rig.points]),
        channels=tuple(c.index for c in sensors),
        at_sensors=shapes([c.point for c in sensors if c.point is not None]),
        derivative=np.array([DERIVATIVE[c.quantity] for c in sensors], dtype=np.int64),
    )
