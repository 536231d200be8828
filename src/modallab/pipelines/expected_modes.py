"""The modes a rig file leads to expect: what the acquisition holds the first hits against."""

import numpy as np

from modallab.acquisition.procedures.struck_point.expected import ExpectedModes
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.twin.structure import Structure, solve


def expected_modes(rig: Rig) -> ExpectedModes | None:
    """The modes of the rig's beam at its points and sensors; None where the rig file describes no beam or no sensor."""
    sensors = [
        c
        for c in rig.responses
        if c.quantity in DERIVATIVE and c.point is not None and c.direction[1] == rig.drive_direction[1]
    ]
    if rig.beam is None or rig.model != "cantilever" or not sensors or not rig.points:
        return None
    modes = solve(Structure.of(rig.beam, rig.damping_ratio.guess))
    unit_mass = np.sqrt(2j * modes.poles.imag)
    return ExpectedModes(
        frequency_hz=modes.frequency_hz,
        damping_ratio=rig.damping_ratio.guess,
        points=tuple(p.id for p in rig.points),
        at_points=np.real(modes.at(np.array([p.x_m for p in rig.points])) * unit_mass),
        channels=tuple(c.index for c in sensors),
        at_sensors=np.real(modes.at(np.array([rig.x_of(c.point) for c in sensors if c.point is not None])) * unit_mass),
        derivative=np.array([DERIVATIVE[c.quantity] for c in sensors], dtype=np.int64),
    )
