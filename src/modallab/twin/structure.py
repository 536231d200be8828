"""The cantilever's numbers, with what may be wrong with it."""

import re
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal

import numpy as np
from scipy.linalg import eigh

from modallab.core.arrays import Complex, Real
from modallab.core.rig import Beam
from modallab.twin.elements import ELEMENTS, FIELD_TERMS, beam_matrices

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


MODES = 15
"""Modes kept: well past the band."""
ROOT = 0.1
"""Relative deviation of a rotational spring at the root that a rig file states as "about" so much."""

Attached = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False, slots=True)
class TwinStructure:
    """A cantilever with what may be wrong with it. Places are in m from the clamp.

    Attributes:
        length_m: length.
        width_m: width.
        thickness_m: thickness h; EI = E b h^3 / 12, rhoA = rho b h, rhoI = rhoA h^2 / 12.
        youngs_modulus_pa: E.
        density_kg_m3: rho.
        zeta: (MODES,) damping ratio of each mode.
        ei_field: (terms,) share of EI in cos(j pi x / L), j = 1, 2, ...
        mass_field: (terms,) the same for rhoA.
        root_rotation: compliance of the root in L / EI; 0 is rigid.
        root_translation: the same across the beam, in L^3 / EI.
        masses: (x, kg).
        springs: (x, N/m) to ground.
        rotation_springs: (x, N m/rad) to ground.
        dampers: (x, N s/m) to ground.
        losses: (x, share of EI lost there, half width in m).
        hung: (x, kg, N/m) of masses that hang on a spring, each with a freedom of its own.
        tension_n: axial force, N; negative where it pushes.
        bedding: stiffness per length to ground, N/m^2.
        side: families of modes beside those of bending along the drive.
    """

    length_m: float
    width_m: float
    thickness_m: float
    youngs_modulus_pa: float
    density_kg_m3: float
    zeta: Real
    ei_field: Real = field(default_factory=lambda: np.zeros(FIELD_TERMS))
    mass_field: Real = field(default_factory=lambda: np.zeros(FIELD_TERMS))
    root_rotation: float = 0.0
    root_translation: float = 0.0
    masses: Attached = ()
    springs: Attached = ()
    rotation_springs: Attached = ()
    dampers: Attached = ()
    losses: tuple[tuple[float, float, float], ...] = ()
    hung: tuple[tuple[float, float, float], ...] = ()
    tension_n: float = 0.0
    bedding: float = 0.0
    side: tuple[SideModes, ...] = ()

    @classmethod
    def of(cls, beam: Beam, damping_ratio: float) -> "TwinStructure":
        """The structure a rig file believes in."""
        return cls(
            beam.length_m,
            beam.width_m,
            beam.thickness_m,
            beam.youngs_modulus_pa,
            beam.density_kg_m3,
            np.full(MODES, damping_ratio),
            root_rotation=root_of_rig_file(beam),
        )

    @property
    def bending_stiffness(self) -> float:
        """EI in N m^2."""
        return self.youngs_modulus_pa * self.width_m * self.thickness_m**3 / 12

    @property
    def mass_per_length(self) -> float:
        """RhoA in kg/m."""
        return self.density_kg_m3 * self.width_m * self.thickness_m


_SPRING = re.compile(r"(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\s*EI/L(?!\^)")


def root_of_rig_file(beam: Beam) -> float:
    """Rotational compliance of the root in L / EI by the words of the rig file: "... 13 EI/L ..."; else 0."""
    spring = _SPRING.search(beam.clamp)
    return 1 / float(spring.group(1)) if spring is not None and float(spring.group(1)) > 0 else 0.0
