"""What a sensor or its preamplifier makes of the motion it sees: a rational filter, as a sum over its poles."""

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np


@dataclass(frozen=True, slots=True)
class SensorTransfer:
    """H(s) = direct + sum of residue / (s - pole), a complex pole standing for the pair.

    Attributes:
        direct: H at infinity.
        poles: with an imaginary part from 0.
        residues: one a pole.
    """

    direct: float = 1.0
    poles: tuple[complex, ...] = ()
    residues: tuple[complex, ...] = ()

    def response_at(self, s: complex | np.ndarray) -> complex | np.ndarray:
        """H(s)."""
        total = self.direct + 0 * s
        for pole, residue in self.poles_and_residues:
            total = total + residue / (s - pole)
        return total

    @property
    def poles_and_residues(self) -> tuple[tuple[complex, complex], ...]:
        """(pole, residue), both of each pair."""
        both: list[tuple[complex, complex]] = []
        for pole, residue in zip(self.poles, self.residues, strict=True):
            both.append((pole, residue))
            if pole.imag:
                both.append((pole.conjugate(), residue.conjugate()))
        return tuple(both)

    def followed_by(self, other: "SensorTransfer") -> "SensorTransfer":
        """This one followed by another, whose poles are others."""
        residues = [complex(r * other.response_at(p)) for p, r in zip(self.poles, self.residues, strict=True)]
        residues += [complex(r * self.response_at(p)) for p, r in zip(other.poles, other.residues, strict=True)]
        return SensorTransfer(self.direct * other.direct, self.poles + other.poles, tuple(residues))


def high_pass(corner_hz: float) -> SensorTransfer:
    """First order, -3 dB at the corner: s / (s + w)."""
    w = 2 * pi * corner_hz
    return SensorTransfer(1.0, (complex(-w),), (complex(-w),))


def low_pass(corner_hz: float) -> SensorTransfer:
    """First order, -3 dB at the corner: w / (s + w)."""
    w = 2 * pi * corner_hz
    return SensorTransfer(0.0, (complex(-w),), (complex(w),))


def loose_mount(hz: float, zeta: float) -> SensorTransfer:
    """A sensor on a mount with spring and damper: (2 zeta w s + w^2) / (s^2 + 2 zeta w s + w^2)."""
    w = 2 * pi * hz
    pole = w * complex(-zeta, sqrt(1 - zeta**2))
    residue = (2 * zeta * w * pole + w**2) / (2j * pole.imag)
    return SensorTransfer(0.0, (pole,), (residue,))
