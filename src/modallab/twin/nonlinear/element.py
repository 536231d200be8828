"""A local nonlinearity: where it acts, what it feels, its law.

Each is the force that the law adds to a linear beam, so that the linear twin stays exact beside it: a slider its moment
to the root that slips, a contact its moment to a root that turns freely.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from modallab.core.arrays import Complex, Real, gauss_legendre
from modallab.twin.elements import (
    ELEMENTS,
    clamped_beam_flexibility,
    curvature_rows,
    shape_rows,
    slope_rows,
    weakened_stiffness,
)
from modallab.twin.modes import TwinModes
from modallab.twin.structure import TwinStructure

PATTERNS = 6
"""Ways in which the beam bends about a crack that are followed where only its low modes do."""
MOMENTS = 2
"""Ways in which it bends where all do: one for each power of the place in the bending moment over the crack."""
PLACES = 12
"""Places along the beam at which a drag is taken."""


class NonlinearLaw(IntEnum):
    """How the force follows the motion."""

    CUBIC = 0
    FRICTION = 1
    PLAY = 2
    CRACK = 3
    DRAG = 4


@dataclass(frozen=True, slots=True)
class NonlinearElement:
    """One nonlinearity of the beam.

    Attributes:
        law: how its force follows the motion.
        x_m: its place from the clamp, m; of a drag, anywhere.
        numbers: of the law. Cubic: (k3 in N/m^3,). Friction: (stiffness of the slider in N m/rad, limit in N m), and
            how sharply it yields, if it is not ideal. Play: (stiffness in N m/rad, half the gap in rad). Crack: (share
            of EI lost while open, half width in m, 1 where all modes of the beam feel it and 0 where those that are
            kept do). Drag: (force per length and squared velocity in N s^2/m^3, number of stations at which it acts; 0
            for evenly).
    """

    law: NonlinearLaw
    x_m: float
    numbers: tuple[float, ...]

    @property
    def of_all_modes(self) -> bool:
        """Whether it feels all modes of the beam, however many are said to answer elsewhere."""
        return self.law is NonlinearLaw.CRACK and bool(self.numbers[2])


@dataclass(frozen=True, eq=False, slots=True)
class ModalCoupling:
    """An element in the coordinates of the modes, with m channels of force.

    Attributes:
        law: of the element.
        numbers: what the law needs.
        shapes: (m, p) of the modes, what each channel feels and where it acts.
        switch: (p,) of the modes, the motion whose sign opens a crack; zeros otherwise.
        rows: (1 + m, n) of the switch and of the channels over the elements' degrees of freedom.
    """

    law: NonlinearLaw
    numbers: tuple[float, ...]
    shapes: Complex
    switch: Complex
    rows: Real


def couple_to_modes(element: NonlinearElement, structure: TwinStructure, modes: TwinModes) -> ModalCoupling:
    """An element on the modes of a structure."""
    length = structure.length_m
    numbers = element.numbers
    none = np.zeros(2 * ELEMENTS + 2)
    if element.law is NonlinearLaw.CUBIC:
        rows, gate = shape_rows(element.x_m, length), none
    elif element.law in (NonlinearLaw.FRICTION, NonlinearLaw.PLAY):
        rows, gate = slope_rows(element.x_m, length), none
    elif element.law is NonlinearLaw.CRACK:
        rows, gate = _opening_of_crack(element, structure, modes)
    else:
        per_length, *stations = numbers
        at, weights = _stations_of_drag(round(stations[0]) if stations else 0)
        rows, gate = shape_rows(length * at, length), none
        numbers = tuple((per_length * length * weights).tolist())
    return ModalCoupling(
        element.law, numbers, rows @ modes.columns, gate @ modes.columns, np.concatenate([gate[None], rows])
    )


def _stations_of_drag(stations: int) -> tuple[Real, Real]:
    """(m,) places over L of a drag, and (m,) the share of each; the last station stands for half a bay."""
    if not stations:
        at, weights = gauss_legendre(PLACES)
        return (at + 1) / 2, weights / 2
    share = np.full(stations, 2.0)
    share[-1] = 1.0
    return np.arange(1, stations + 1) / stations, share / np.sum(share)


def _opening_of_crack(element: NonlinearElement, structure: TwinStructure, modes: TwinModes) -> tuple[Real, Real]:
    """(m, n) what bends about a crack, so that its stiffness is the sum of squares of these, and (n,) what opens it.

    What a crack takes off the stiffness is of many patterns; those count that the beam bends.
    """
    share, width, _ = element.numbers
    loss = -structure.bending_stiffness * weakened_stiffness(element.x_m, width, structure.length_m, share)
    values, vectors = np.linalg.eigh(loss)
    kept = values > 1e-12 * values[-1]
    rows = (vectors[:, kept] * np.sqrt(values[kept])).T
    if element.of_all_modes:
        return _bending_by_moments(rows, element.x_m, structure)
    # Each mode at the same energy.
    curvatures = rows @ np.real(modes.columns * np.sqrt(2j * modes.poles.imag)) / np.abs(modes.poles)
    turned = np.linalg.svd(curvatures)[0]
    return turned.T[:PATTERNS] @ rows, curvature_rows(element.x_m, structure.length_m)[0]


def _bending_by_moments(rows: Real, x_m: float, structure: TwinStructure) -> tuple[Real, Real]:
    """The ways in which an open crack bends under a constant moment over it, and under one that falls, and the moment.

    A deep crack bends far more sharply in its middle than any mode of the intact beam.
    """
    rigidity, length = structure.bending_stiffness, structure.length_m
    # Of unit moments where the crack is closed, and where it is open.
    closed = rows @ _static_deflection(x_m, length) / rigidity
    opened = np.linalg.solve(np.eye(len(rows)) - rows @ (clamped_beam_flexibility(length) / rigidity) @ rows.T, closed)
    turned = np.linalg.qr(opened)[0]
    channels = turned.T @ rows
    return channels, np.linalg.solve(turned.T @ closed, channels)[0]


def _static_deflection(x_m: float, length_m: float) -> Real:
    """(n, MOMENTS) deflection of unit EI under moments (s - x)^j / L^j, s along the beam."""
    arm = np.linspace(0, length_m, ELEMENTS + 1) - x_m
    curvatures = np.empty((2 * ELEMENTS + 2, MOMENTS))
    for j in range(MOMENTS):
        curvatures[1::2, j] = arm ** (j + 1) / (j + 1) / length_m**j
        curvatures[::2, j] = arm ** (j + 2) / (j + 1) / (j + 2) / length_m**j
    return curvatures
