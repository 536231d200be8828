"""What FRFs hold beside the products of shapes: of modes outside the band, and what no model has of them.

Where all stiffness of a structure is kappa times as large, and all mass mu times, with the same damping ratios, its
FRFs are H(s sqrt(mu / kappa)) / kappa: all of them goes along, whatever it is.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from modallab.core.arrays import Complex

SHIFTS = np.linspace(-0.06, 0.06, 25)
"""Logarithms of s over where it was, between which it is interpolated: FRFs off the axis are smooth over more."""


@dataclass(frozen=True, eq=False, slots=True)
class BesideModes:
    """It on lines, shifted in frequency.

    Attributes:
        nodes: (shifts, lines, outputs, inputs) m/N.
        curve: of these.
    """

    nodes: Complex
    curve: CubicSpline

    @classmethod
    def of(cls, receptances: Callable[[Complex], Complex], s: Complex) -> "BesideModes":
        """Of what gives (lines, outputs, inputs) at complex frequencies (lines,)."""
        return cls.through(np.array([receptances(s * np.exp(shift)) for shift in SHIFTS]))

    @classmethod
    def through(cls, nodes: Complex) -> "BesideModes":
        """Through values at all shifts."""
        return cls(nodes, CubicSpline(SHIFTS, nodes))

    def thinned(self, lines: slice) -> "BesideModes":
        """On some of the lines."""
        return self.through(self.nodes[:, lines])

    def scaled(self, stiffness: float, mass: float) -> Complex:
        """(lines, outputs, inputs) with factors on all stiffness and all mass."""
        return np.asarray(self.curve(_shift(stiffness, mass)), np.complex128) / stiffness

    def slope(self, stiffness: float, mass: float) -> Complex:
        """(lines, outputs, inputs) derivative of that by the logarithm of the mass."""
        shift = _shift(stiffness, mass)
        inside = SHIFTS[0] < shift < SHIFTS[-1]
        return inside * np.asarray(self.curve(shift, 1), np.complex128) / (2 * stiffness)


def _shift(stiffness: float, mass: float) -> float:
    return float(np.clip(np.log(mass / stiffness) / 2, SHIFTS[0], SHIFTS[-1]))
