"""What may be wrong, as coordinates for a fit: every effect the twin can predict, at every place it may be.

Positive numbers are searched as logarithms, shares as logits, so that no step leaves their range (Gelman et al.,
Bayesian Data Analysis, 2013).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.effects import Effect, Place
from modallab.core.rig import Rig
from modallab.twin.elements import ELEMENTS

Array = NDArray[np.float64]
Transform = Literal["log", "plain", "share"]

SOFT = 0.01
"""Stiffness of a root, in those of the beam, below which nothing stands any more."""


@dataclass(frozen=True, slots=True)
class Slot:
    """One free number of an effect.

    Attributes:
        name: the parameter; "x" for the place along the beam.
        transform: log (positive), plain (either sign, in `scale`), share (0 to 1).
        starts: values worth a first look, SI.
        scale: unit of a plain number.
        low: smallest value it may take.
        high: largest.
        inverse: whether a large number is a small effect, as of the stiffness of a clamp.
    """

    name: str
    transform: Transform
    starts: tuple[float, ...]
    scale: float = 1.0
    low: float = -np.inf
    high: float = np.inf
    inverse: bool = False

    def value(self, u: float) -> float:
        """The number at coordinate u, held within its range."""
        if self.transform == "log":
            free = float(np.exp(np.clip(u, -60, 60)))
        elif self.transform == "share":
            free = float(1 / (1 + np.exp(-np.clip(u, -30, 30))))
        else:
            free = u * self.scale
        return min(max(free, self.low), self.high)

    def coordinate(self, value: float) -> float:
        """The coordinate of a number."""
        if self.transform == "log":
            return float(np.log(value))
        if self.transform == "share":
            return float(np.log(value / (1 - value)))
        return value / self.scale

    def slope(self, u: float) -> float:
        """Derivative of the number by its coordinate."""
        value = self.value(u)
        return {"log": value, "share": value * (1 - value), "plain": self.scale}[self.transform]


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect at a place, its numbers free.

    Attributes:
        effect: its name.
        slots: its free numbers.
        place: the fixed part of its place.
        fixed: parameters that are not free.
    """

    effect: str
    slots: tuple[Slot, ...]
    place: tuple[tuple[str, Place], ...] = ()
    fixed: tuple[tuple[str, float], ...] = ()

    def at(self, u: Array) -> Effect:
        """The effect at coordinates u."""
        values = {s.name: s.value(float(v)) for s, v in zip(self.slots, u, strict=True)}
        place = dict(self.place)
        if "x" in values:
            place["x"] = min(max(values.pop("x"), 0.5 / ELEMENTS), 1.0)
        return Effect(effect=self.effect, parameters={**dict(self.fixed), **values}, place=place)


def _spread(low: float, high: float, count: int) -> tuple[float, ...]:
    return tuple(float(v) for v in np.geomspace(low, high, count))


def _both(low: float, high: float, count: int) -> tuple[float, ...]:
    values = _spread(low, high, count)
    return (*(-v for v in reversed(values)), *values)


def _along() -> Slot:
    return Slot("x", "plain", tuple(float(v) for v in np.linspace(0.1, 0.98, 12)), low=0.0, high=1.0)


def structural(rig: Rig) -> list[Candidate]:
    """Linear effects in the structure, and those of the shaker's attachment."""
    beam = rig.beam
    assert beam is not None
    length = beam.length_m
    ei = beam.youngs_modulus_pa * beam.width_m * beam.thickness_m**3 / 12
    mass = beam.density_kg_m3 * beam.width_m * beam.thickness_m * length
    critical = np.sqrt(ei * mass / length**3)
    here = (("x", 0.0),)
    shaker = (("x", rig.x_of(rig.shaker_point) / length),) if rig.shaker_point is not None else ()
    along, stiff = _along(), ei / length**3
    turning = Slot("k_rot", "log", _spread(4 * ei / length, 4e3 * ei / length, 7), low=SOFT * ei / length, inverse=True)
    shifting = Slot("k_trans", "log", _spread(50 * stiff, 5e4 * stiff, 7), low=SOFT * stiff, inverse=True)
    found = [
        Candidate("clamp_rotation", (turning,), here),
        Candidate("clamp_translation", (shifting,), here),
        Candidate("sensor_mass", (Slot("mass_each", "log", _spread(3e-5 * mass, 0.03 * mass, 7)),), (("x", "all"),)),
        Candidate("added_mass", (Slot("mass", "log", _spread(1e-3 * mass, 0.4 * mass, 5)), along)),
        Candidate("stiffness_loss", (Slot("EI_loss", "share", (0.05, 0.2, 0.45, 0.7, 0.85), high=0.97), along)),
        Candidate("ground_spring", (Slot("k", "log", _spread(0.01 * ei / length**3, 30 * ei / length**3, 9)), along)),
        Candidate("local_damper", (Slot("c", "log", _spread(1e-3 * critical, critical, 5)), along)),
        Candidate("thermal_drift", (Slot("EI_drift", "plain", _both(1e-3, 0.12, 10), 0.01, low=-0.4, high=0.4),)),
    ]
    if shaker:
        found += [
            Candidate("shaker_mass", (Slot("mass", "log", _spread(1e-3 * mass, 0.5 * mass, 14)),), shaker),
            Candidate(
                "stinger_moment", (Slot("k_rot", "log", _spread(0.02 * ei / length, 100 * ei / length, 12)),), shaker
            ),
        ]
    return found


def chained(rig: Rig) -> list[Candidate]:
    """Effects of the chain and of the hit that leave the poles alone and concern all channels."""
    beam = rig.beam
    assert beam is not None
    length = beam.length_m
    everywhere = (("channel", "all"),)
    return [
        Candidate("ac_coupling", (Slot("corner_hz", "log", _spread(0.01, 8.0, 7), low=1e-4, high=25.0),), everywhere),
        Candidate(
            "force_gain",
            (Slot("gain", "log", (0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6), low=0.1, high=5.0),),
            (("channel", 0),),
        ),
        Candidate(
            "channel_skew",
            (Slot("seconds_per_channel", "plain", _spread(1e-7, 2e-4, 7), 1e-5, low=0.0, high=3e-4),),
            everywhere,
        ),
        Candidate(
            "trigger_delay", (Slot("seconds", "plain", _spread(1e-6, 4e-3, 9), 1e-4, low=0.0, high=8e-3),), everywhere
        ),
        Candidate(
            "clock_error", (Slot("relative", "plain", _both(1e-4, 0.04, 7), 0.01, low=-0.1, high=0.1),), everywhere
        ),
        Candidate(
            "hit_position", (Slot("dx", "plain", _both(2e-3 * length, 0.06 * length, 4), 0.01),), (("where", "hit"),)
        ),
    ]


def of_channel(rig: Rig, channel: int) -> list[Candidate]:
    """Effects on one accelerometer."""
    beam = rig.beam
    assert beam is not None
    place = (("channel", channel),)
    length = beam.length_m
    return [
        Candidate(
            "gain_error", (Slot("gain", "log", (0.5, 0.7, 0.85, 0.95, 1.05, 1.15, 1.3, 1.6), low=0.1, high=5.0),), place
        ),
        Candidate("polarity", (), place, (("sign", -1.0),)),
        Candidate("position_error", (Slot("dx", "plain", _both(2e-3 * length, 0.08 * length, 4), 0.01),), place),
        Candidate(
            "loose_mount",
            (
                Slot("hz", "log", (60.0, 90.0, 140.0, 210.0, 320.0, 500.0, 1e3, 2e3, 4e3, 8e3), low=40.0, high=2e4),
                Slot("zeta", "log", (0.04,), low=1e-3, high=0.4),
            ),
            place,
        ),
    ]


def swaps(channels: tuple[int, ...]) -> list[Candidate]:
    """Every exchange of two of these channels."""
    pairs = [(a, b) for i, a in enumerate(channels) for b in channels[i + 1 :]]
    return [Candidate("swap", (), (("channel", pair),)) for pair in pairs]
