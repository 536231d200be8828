"""The cantilever's numbers, with what may be wrong with it."""

import re
from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Real
from modallab.core.rig import Beam
from modallab.twin.elements import FIELD_TERMS
from modallab.twin.side_modes import SideModes

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
