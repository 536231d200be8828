"""The supply of IEPE sensors: what an input sees before, while and after the excitation comes on."""

from dataclasses import dataclass

import numpy as np

from modallab_simulators.ni_daqmx_server.lines import Floats

STEP_V = 4.9
"""What the input's coupling capacitor is charged by when the excitation comes on."""
TIME_S = 0.454
"""Time constant of AC coupling: 4.9 V are 6.6 mV after 3 s."""


@dataclass(frozen=True, slots=True)
class Supply:
    """One input's supply.

    Attributes:
        since_s: bench time since which the excitation is on; None: it is off.
        sensor: whether the sensor needs it.
    """

    since_s: float | None
    sensor: bool = True

    def seen(self, volts: Floats, times_s: Floats) -> Floats:
        """What the input sees of a sensor's `volts` at bench times: nothing without a supply."""
        if self.since_s is None:
            return np.zeros_like(volts) if self.sensor else volts
        return volts + STEP_V * np.exp(-np.maximum(times_s - self.since_s, 0.0) / TIME_S)
