"""Families of modes beside those of bending along the drive: a beam that twists, or bends across, or something else.

A clamped bar twists in odd quarter waves at 1, 3, 5, ... times its first frequency (Blevins, Formulas for Natural
Frequency and Mode Shape, 1979, table 8-16); across the drive the beam bends as along it, but stiffer. Hammer, shaker
and sensors that sit off the centre line, or a little askew, drive and sense such modes in one and the same proportion.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.linalg import eigh

from modallab.core.arrays import Complex, Real
from modallab.twin.elements import ELEMENTS, beam_matrices

MEMBERS = 4
"""Modes of a family that swing: those beyond lie far above the band, and give way as springs do."""
IN_ALL = 40
"""Modes of a family in all."""

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


def frequency_multiples(family: Family) -> Real:
    """(members,) natural frequencies of a family over its lowest."""
    return _members_of_family(family, 1.0, 1.0)[0][:MEMBERS]


def poles_and_columns(side: SideModes, length_m: float) -> tuple[Complex, Complex]:
    """(members,) poles and (n, members) complex shapes over the beam's degrees of freedom, scaled as `Modes` are."""
    ratios, shapes = _members_of_family(side.family, side.power, length_m)
    omega = 2 * np.pi * side.hz * ratios[:MEMBERS]
    damped = omega * np.sqrt(max(1 - side.zeta**2, 1e-6))
    columns = shapes[:, :MEMBERS] / np.sqrt(side.kg) / np.sqrt(2j * damped)
    return -side.zeta * omega + 1j * damped, columns.astype(np.complex128)


def out_of_band_compliance(side: SideModes, length_m: float) -> Real:
    """(n, n) static compliance in m/N of the family's modes beyond those, over the same degrees of freedom."""
    return _given_way(side.family, side.power, length_m) / side.kg / (2 * np.pi * side.hz) ** 2


@lru_cache(maxsize=16)
def _given_way(family: Family, power: float, length_m: float) -> Real:
    ratios, shapes = _members_of_family(family, power, length_m)
    over = shapes[:, MEMBERS:] / ratios[MEMBERS:]
    return over @ over.T


@lru_cache(maxsize=16)
def _members_of_family(family: Family, power: float, length_m: float) -> tuple[Real, Real]:
    """(modes,) frequencies over the lowest, and (n, modes) deflection and slope at the nodes, 1 at the tip."""
    if family == "across":
        return _modes_across(length_m)
    x = np.linspace(0.0, 1.0, ELEMENTS + 1)[:, None]
    if family == "twist":
        ratios = np.arange(1.0, 2.0 * IN_ALL, 2.0)
        wave = np.pi / 2 * ratios
        deflection, slope = np.sin(wave * x) / np.sin(wave), wave * np.cos(wave * x) / np.sin(wave)
    else:
        ratios = np.ones(1)
        deflection, slope = x**power, power * x ** max(power - 1, 0.0)
    nodal = np.stack([deflection, slope / length_m], axis=1)
    return ratios, nodal.reshape(2 * len(x), -1)


def _modes_across(length_m: float) -> tuple[Real, Real]:
    """Of the bare clamped beam."""
    pattern = beam_matrices(length_m)
    values, vectors = eigh(pattern.mass[0][2:, 2:], pattern.stiffness[0][2:, 2:], check_finite=False)
    lowest = values[: -IN_ALL - 1 : -1]
    shapes = np.zeros((2 * ELEMENTS + 2, IN_ALL))
    shapes[2:] = vectors[:, : -IN_ALL - 1 : -1]
    return np.sqrt(lowest[0] / lowest), shapes / shapes[-2]
