"""What a sensor or its preamplifier makes of the motion it sees: a rational filter, as a sum over its poles."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np


@dataclass(frozen=True, slots=True)
class Sensor:
    """H(s) = direct + sum of residue / (s - pole), a complex pole standing for the pair.

    Attributes:
        direct: H at infinity.
        poles: with an imaginary part from 0.
        residues: one a pole.
    """

    direct: float = 1.0
    poles: tuple[complex, ...] = ()
    residues: tuple[complex, ...] = ()

    def at(self, s: complex | np.ndarray) -> complex | np.ndarray:
        """H(s)."""
        total = self.direct + 0 * s
        for pole, residue in self.pairs:
            total = total + residue / (s - pole)
        return total

    @property
    def pairs(self) -> tuple[tuple[complex, complex], ...]:
        """(pole, residue), both of each pair."""
        both: list[tuple[complex, complex]] = []
        for pole, residue in zip(self.poles, self.residues, strict=True):
            both.append((pole, residue))
            if pole.imag:
                both.append((pole.conjugate(), residue.conjugate()))
        return tuple(both)

    def then(self, other: "Sensor") -> "Sensor":
        """This one followed by another, whose poles are others."""
        residues = [complex(r * other.at(p)) for p, r in zip(self.poles, self.residues, strict=True)]
        residues += [complex(r * self.at(p)) for p, r in zip(other.poles, other.residues, strict=True)]
        return Sensor(self.direct * other.direct, self.poles + other.poles, tuple(residues))


def high_pass(corner_hz: float) -> Sensor:
    """First order, -3 dB at the corner: s / (s + w)."""
    w = 2 * pi * corner_hz
    return Sensor(1.0, (complex(-w),), (complex(-w),))


def low_pass(corner_hz: float) -> Sensor:
    """First order, -3 dB at the corner: w / (s + w)."""
    w = 2 * pi * corner_hz
    return Sensor(0.0, (complex(-w),), (complex(w),))


def mount(hz: float, zeta: float) -> Sensor:
    """A sensor on a mount with spring and damper: (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2)."""
    w = 2 * pi * hz
    pole = w * complex(-zeta, sqrt(1 - zeta**2))
    residue = (2 * zeta * w * pole + w**2) / (2j * pole.imag)
    return Sensor(0.0, (pole,), (residue,))
