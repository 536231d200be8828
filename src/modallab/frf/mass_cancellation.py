"""The mass between a force transducer and the structure, taken off again.

The transducer feels what the structure takes and what the mass in front of it takes: F = F_structure + m a, with a at
the driving point. So A_jk = A'_jk / (1 - m A'_kk) for measured inertances A'. Left in, it lowers every frequency at
which the driven point moves.
Source: Ewins, "Modal Testing", 2nd ed. (2000), section 3.8.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf


def without_mass(frf: Frf, mass_kg: Sequence[float]) -> Frf:
    """The FRFs of the structure alone.

    Args:
        frf: any quantity, with a sensor at every driven point in front of which there is a mass.
        mass_kg: (inputs,) between transducer and structure, 0 for none.

    Returns:
        The same quantity; the variance goes with the values, coherence stays.

    Raises:
        DataError: masses that are none or not one an input, no sensor at the driven point, or a mass that is more than
            the transducer felt: 1 - m A vanishes.
    """
    inertance = convert_frf(frf, "inertance")
    _check(mass_kg, len(frf.input_points))
    factor = np.ones((len(mass_kg), frf.frequency_hz.size), complex)
    for k, (mass, point) in enumerate(zip(mass_kg, frf.input_points, strict=True)):
        if mass > 0:
            factor[k] = 1 - mass * inertance.values[_driving_index(frf.output_points, point), k]
    if np.any(factor == 0):
        raise DataError("at some line the masses need the whole force", remedy="check the masses, in kg")
    cleared = replace(
        inertance,
        values=inertance.values / factor,
        variance=None if inertance.variance is None else inertance.variance / np.abs(factor) ** 2,
    )
    return convert_frf(cleared, frf.quantity)


def _check(mass_kg: Sequence[float], inputs: int) -> None:
    if len(mass_kg) != inputs or not all(np.isfinite(m) and m >= 0 for m in mass_kg):
        found = f"masses {[float(m) for m in mass_kg]} kg are not one for each of {inputs} inputs, or below zero"
        raise DataError(found, remedy="give one mass an input in kg, 0 for none")


def _driving_index(points: Sequence[int | None], point: int | None) -> int:
    if point is None or point not in points:
        raise DataError(
            f"no sensor stands at the driven point {'(unknown)' if point is None else point}",
            remedy="put a sensor there: its acceleration gives the force on the mass",
        )
    return list(points).index(point)
