"""What is always free: the beam within its tolerances, damping, sensitivities in doubt, a root known to be soft.

Priors are log-normal for what is positive: u deviations multiply a number by exp(u tolerance). Frequencies of the bare
cantilever by Blevins, Formulas for Dynamics, Acoustics and Vibration, 2016.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import log
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effect import RowsOfPlace
from modallab.core.errors import RigError
from modallab.core.rig import Beam, Rig
from modallab.gap.model.tolerances import (
    Departed,
    Deviation,
    Scales,
    apply_tolerances,
    deviations,
    limit_smoothly,
    sensors_x_m,
)
from modallab.twin.bench import MeasurementChain, Twin
from modallab.twin.effects import with_revision_effects
from modallab.twin.structure import MODES, ROOT, TwinStructure, root_of_rig_file


@dataclass(frozen=True, eq=False, slots=True)
class Nuisances:
    """Free numbers in units of their prior's deviation: E, thickness, density, damping ratios, sensitivities.

    Then the root's spring, where the rig file states one, and the share of the static compliance of the modes that
    the twin leaves out.

    Attributes:
        rig: the bench as believed.
        modes: damping ratios that are free; those above the band stay at the guess.
        gains: accelerometers whose sensitivity is free.
        tolerance: relative deviation of a sensitivity.
        root: whether the root's spring is free.
        deviations: further tolerances that the rig file states.
        stepped: whether an element that the rig's revisions know is in the twin; where not, the beam it acts on is.
    """

    rig: Rig
    modes: int
    gains: tuple[int, ...] = ()
    tolerance: float = 0.0
    root: bool = False
    deviations: tuple[Deviation, ...] = ()
    stepped: bool = True

    @property
    def size(self) -> int:
        """How many."""
        return 4 + self.modes + len(self.gains) + len(self.deviations) + self.root

    @property
    def first_deviation(self) -> int:
        """Where the deviations begin."""
        return 3 + self.modes + len(self.gains)

    @property
    def axes(self) -> Real:
        """(3, 3) columns: what moves E, thickness and density so that only all frequencies, only the mass, and neither
        of them changes, in units of the priors' deviations."""
        t = self.rig.tolerance
        deviations = np.maximum([t.youngs_modulus, t.thickness, t.density], 1e-6)
        return np.array([[1.0, 1.0, -3.0], [0.0, 0.0, 1.0], [0.0, 1.0, -1.0]]) / deviations[:, None]

    def within_priors(self, u: Real) -> Real:
        """The same beam but for its rotary inertia, with the most likely thickness.

        Frequencies and amplitudes hardly determine the thickness: a fit from far off may have left it anywhere.
        """
        along = self.axes[:, 2]
        straight = u.copy()
        straight[:3] -= along * float(along @ u[:3]) / float(along @ along)
        return straight

    def without_gains(self, u: Real, channels: Sequence[object]) -> Real:
        """The same numbers (..., size) with the sensitivities of some channels at what the rig file says."""
        gone = [3 + self.modes + i for i, channel in enumerate(self.gains) if channel in channels]
        if not gone:
            return u
        u = u.copy()
        u[..., gone] = 0.0
        return u

    def build(self, u: Real) -> Twin:
        """The twin of numbers (size,) without other effects than those that the rig's revisions know."""
        return self.builds(u[None])[0]

    def builds(self, u: Real, replaced: Collection[tuple[str, RowsOfPlace | None]] = ()) -> list[Twin]:
        """The twins of many numbers (twins, size) at once.

        Args:
            u: the free numbers.
            replaced: (tolerance, channel or None) that effects stand for: one quantity is one number.
        """
        twins = [with_revision_effects(twin, self.rig) for twin in self._bare(u, replaced)]
        return twins if self.stepped else [replace(twin, element=None) for twin in twins]

    def bare(self, u: Real, replaced: Collection[tuple[str, RowsOfPlace | None]] = ()) -> Twin:
        """The twin of numbers (size,) without these either."""
        return next(self._bare(u[None], replaced))

    def _bare(self, u: Real, replaced: Collection[tuple[str, RowsOfPlace | None]]) -> Iterator[Twin]:
        nominal, chain, x_of, scales = _nominal(self)
        beams = self._beams(u, ("clamp_compliance", None) not in replaced)
        first = 3 + self.modes
        gains = np.exp(limit_smoothly(u[:, first : first + len(self.gains)]) * self.tolerance).tolist()
        # Between none of the modes left out and all of them, with some room for what else is stiff and light.
        shares = (0.5 + limit_smoothly(u[:, -1] - 0.5, 0.6, 1.0)).tolist()
        first = self.first_deviation
        values = scales.values(u[:, first : first + len(self.deviations)]).tolist()
        for beam, own_gains, share, numbers in zip(beams, gains, shares, values, strict=True):
            own = replace(chain, gain=dict(zip(self.gains, own_gains, strict=True))) if self.gains else chain
            twin = Twin(replace(nominal, **beam), own, residual_compliance=share)
            if self.deviations:
                twin = apply_tolerances(twin, self.rig, _without(scales.by_tolerance(numbers), replaced), x_of)
            yield twin

    def _beams(self, u: Real, softer: bool) -> Iterator[dict[str, Any]]:
        """What the first numbers (twins, size) make of the beam, by the names of `TwinStructure`; `softer` "
        "of its root."""
        tolerance, damping = self.rig.tolerance, self.rig.damping_ratio
        nominal = _nominal(self)[0]
        believed = np.array([nominal.youngs_modulus_pa, nominal.thickness_m, nominal.density_kg_m3])
        # What lies far outside its tolerance is a gap, and must not hide in a nuisance.
        deviations = np.array([tolerance.youngs_modulus, tolerance.thickness, tolerance.density])
        sizes = believed * np.exp(limit_smoothly(u[:, :3]) * deviations)
        zeta = np.tile(nominal.zeta, (len(u), 1))
        zeta[:, : self.modes] *= np.exp(np.clip(u[:, 3 : 3 + self.modes], -20, 8) * log(damping.factor))
        zeta = np.minimum(zeta, 0.95)
        # What is soft at the root is one number: an effect that stands for it leaves the spring as it is believed.
        roots = nominal.root_rotation * (
            np.exp(limit_smoothly(u[:, -2]) * ROOT) if self.root and softer else np.ones(len(u))
        )
        for (youngs_modulus, thickness, density), own, root in zip(sizes.tolist(), zeta, roots.tolist(), strict=True):
            yield {
                "youngs_modulus_pa": youngs_modulus,
                "thickness_m": thickness,
                "density_kg_m3": density,
                "zeta": own,
                "root_rotation": root,
            }


def _without(values: Departed, replaced: Collection[tuple[str, RowsOfPlace | None]]) -> Departed:
    """Numbers of tolerances, those left out that an effect stands for."""
    for name, at in replaced:
        if at is None:
            values.pop(name, None)
        elif name in values and isinstance(at, int | float):
            values[name].pop(at, None)
    return values


@lru_cache(maxsize=16)
def _nominal(free: Nuisances) -> tuple[TwinStructure, MeasurementChain, dict[float, float], Scales]:
    """What the rig file says of beam, chain, places of the sensors and deviations: read once a search."""
    rig = free.rig
    structure = TwinStructure.of(beam_of(rig), rig.damping_ratio.guess)
    return structure, MeasurementChain.of(rig), sensors_x_m(rig), Scales.of_all(free.deviations)


def beam_of(rig: Rig) -> Beam:
    """The rig's beam.

    Raises:
        RigError: it has none.
    """
    if rig.beam is None:
        raise RigError(
            "the rig file has no beam",
            where=rig.name,
            remedy="give the beam's length, section and material, or name a modal model to compare with (--reference)",
        )
    return rig.beam


def nuisances(rig: Rig, top_hz: float, hits: Collection[tuple[float, int]] = ()) -> Nuisances:
    """The nuisances of a rig whose data reach up to `top_hz`, with hits at these places, in m, so many at each.

    Raises:
        RigError: the rig has no beam.
    """
    beam = beam_of(rig)
    ratios = np.array([0.5596, 3.507, 9.819, *((np.arange(4, MODES + 1) - 0.5) ** 2 * np.pi / 2)])
    radius = beam.thickness_m / np.sqrt(12)
    hz = ratios * radius * np.sqrt(beam.youngs_modulus_pa / beam.density_kg_m3) / beam.length_m**2
    modes = int(min(MODES, 1 + np.count_nonzero(hz < top_hz)))
    # A tolerance that the rig file does not state is no licence to turn every gain.
    stated = "sensitivity" in rig.tolerance.model_fields_set and rig.tolerance.sensitivity > 0
    gains = tuple(c.index for c in rig.responses) if stated else ()
    tolerance = rig.tolerance.sensitivity if stated else 0.0
    return Nuisances(rig, modes, gains, tolerance, root_of_rig_file(beam) > 0, deviations(rig, hits))
