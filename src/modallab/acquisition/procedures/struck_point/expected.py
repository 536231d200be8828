"""The modes a structure is believed to have: what a hit at each point should excite."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real


@dataclass(frozen=True, eq=False, slots=True)
class ExpectedModes:
    """A belief, from the rig's beam or a model of an earlier test. Good to some per cent is good enough.

    Attributes:
        frequency_hz: (modes,) ascending.
        damping_ratio: of every mode.
        points: (points,) numbers of the points.
        at_points: (points, modes) shapes at unit modal mass, kg^-1/2.
        channels: (sensors,) places in the rig of the channels that sense this motion.
        at_sensors: (sensors, modes) the same where they are.
        derivative: (sensors,) of the displacement: 0, 1 or 2.
    """

    frequency_hz: Real
    damping_ratio: float
    points: tuple[int, ...]
    at_points: Real
    channels: tuple[int, ...]
    at_sensors: Real
    derivative: NDArray[np.int64]
