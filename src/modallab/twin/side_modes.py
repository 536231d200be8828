"""Families of modes beside those of bending along the drive: a beam that twists, or bends across, or something else.

A clamped bar twists in odd quarter waves at 1, 3, 5, ... times its first frequency (Blevins, Formulas for Natural
Frequency and Mode Shape, 1979, table 8-16); across the drive the beam bends as along it, but stiffer. Hammer, shaker
and sensors that sit off the centre line, or a little askew, drive and sense such modes in one and the same proportion.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from modallab.twin.elements import ELEMENTS, patterns

MEMBERS = 4
"""Modes of a family: those beyond lie far above the band, and are hardly seen."""

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
Family = Literal["twist", "across", "alone"]


@dataclass(frozen=True, slots=True)
class SideModes:
    """A family of modes.

    Attributes:
        family: twist: of a clamped bar; across: of bending across the drive; alone: one mode along (x / L)^power.
        hz: the lowest natural frequency.
        kg: mass that the tip, where all of the family are largest, shows each of them to swing as.
        zeta: damping ratio of all.
        power: of the shape of a mode alone.
    """

    family: Family
    hz: float
    kg: float
    zeta: float
    power: float = 1.0


def multiples(family: Family) -> Array:
    """(members,) natural frequencies of a family over its lowest."""
    if family == "alone":
        return np.ones(1)
    return np.arange(1.0, 2.0 * MEMBERS, 2.0) if family == "twist" else _across(1.0)[0]


def poles_and_columns(side: SideModes, length_m: float) -> tuple[Complex, Complex]:
    """(members,) poles and (n, members) complex shapes over the beam's degrees of freedom, scaled as `Modes` are."""
    omega = 2 * np.pi * side.hz * multiples(side.family)
    damped = omega * np.sqrt(max(1 - side.zeta**2, 1e-6))
    columns = _shapes(side, length_m) / np.sqrt(side.kg) / np.sqrt(2j * damped)
    return -side.zeta * omega + 1j * damped, columns.astype(np.complex128)


def _shapes(side: SideModes, length_m: float) -> Array:
    """(n, members) deflection and slope at the nodes, 1 at the tip."""
    if side.family == "across":
        return _across(length_m)[1]
    x = np.linspace(0.0, 1.0, ELEMENTS + 1)[:, None]
    if side.family == "twist":
        wave = np.pi / 2 * multiples("twist")
        deflection, slope = np.sin(wave * x) / np.sin(wave), wave * np.cos(wave * x) / np.sin(wave)
    else:
        deflection, slope = x**side.power, side.power * x ** max(side.power - 1, 0.0)
    nodal = np.stack([deflection, slope / length_m], axis=1)
    return nodal.reshape(2 * len(x), -1)


@lru_cache(maxsize=8)
def _across(length_m: float) -> tuple[Array, Array]:
    """Frequencies of the bare clamped beam over its lowest, and its shapes, 1 at the tip; not to be written to."""
    pattern = patterns(length_m)
    values, vectors = eigh(pattern.mass[0][2:, 2:], pattern.stiffness[0][2:, 2:], check_finite=False)
    lowest = values[: -MEMBERS - 1 : -1]
    shapes = np.zeros((2 * ELEMENTS + 2, MEMBERS))
    shapes[2:] = vectors[:, : -MEMBERS - 1 : -1]
    shapes /= shapes[-2]
    ratios = np.sqrt(lowest[0] / lowest)
    ratios.flags.writeable = shapes.flags.writeable = False
    return ratios, shapes
