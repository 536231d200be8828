"""The rigid-mass ratio before and after a test (ISO 7626-5): the whole chain compared with Newton's second law."""

from datetime import date
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.commissioning.calibrate import sensitivity_by_rigid_mass
from modallab.core.metrology import MassRatio
from modallab.core.rig import Channel, Rig
from modallab.signals.conversion import volts_per_si


def measure_mass_ratio(
    rig: Rig, volts: NDArray[np.float64], sensor: Channel, mass_kg: float, when: Literal["before", "after"], on: date
) -> MassRatio:
    """The ratio from (channels, n) volts while the free mass is struck or shaken, with the sensitivities of the rig.

    Raises:
        DataError: force and acceleration do not go together as those of one rigid mass.
    """
    per_si = volts_per_si(rig, "impact")
    force = rig.force_channel.index
    acceleration = volts[sensor.index] / per_si[sensor.index]
    slope, sigma = sensitivity_by_rigid_mass(volts[force], acceleration, mass_kg)
    believed = abs(per_si[force])
    return MassRatio(
        date=on,
        when=when,
        channel=sensor.name,
        mass_kg=mass_kg,
        ratio=float(abs(slope) / believed),
        sigma=float(sigma / believed),
    )
