"""Supplies of IEPE sensors: the bias steps when one comes on, and stays off the samples only where the input is AC."""

from dataclasses import dataclass, field

import numpy as np

from modallab_simulators.ni_daqmx_server.lines import Floats

BIAS_V = 10.0
STEP_V = 4.9
"""What passes the coupling of the bias at first."""

DECAY_S = 0.455
"""Time constant of an AC coupling of 0.35 Hz."""

AC = 10045


@dataclass(slots=True)
class Supplies:
    """Since when the sensor at each input has been fed, in s of the bench."""

    since_s: dict[str, float] = field(default_factory=dict[str, float])

    def switch_on(self, names: set[str], now_s: float) -> None:
        """Feed the sensors at these inputs; one that is fed already stays warm."""
        for name in names:
            self.since_s.setdefault(name, now_s)

    def switch_off(self, names: set[str]) -> None:
        """Feed them no longer."""
        for name in names:
            self.since_s.pop(name, None)

    def bias_v(self, name: str, times_s: Floats, *, ac: bool) -> Floats:
        """(n,) volts the bias adds at times of the bench."""
        if not ac:
            return np.full(len(times_s), BIAS_V)
        return STEP_V * np.exp(-np.maximum(times_s - self.since_s.get(name, 0.0), 0.0) / DECAY_S)
