"""The modes a rig file leads to expect: what the acquisition holds the first hits against."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.procedures.struck_point.expected import ExpectedModes
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure


def expected_modes(rig: Rig) -> ExpectedModes | None:
    """The modes of the rig's beam at its points and sensors; None where the rig file describes no beam or no sensor."""
    sensors = [
        c
        for c in rig.responses
        if c.quantity in DERIVATIVE and c.point is not None and c.direction[1] == rig.drive_direction[1]
    ]
    if rig.beam is None or rig.model != "cantilever" or not sensors or not rig.points:
        return None
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
