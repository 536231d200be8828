"""By how much two measurements of one structure differ though nothing was changed, where the reference was measured.

What a rig file says of E, density and thickness is how well a structure is known before it is tested. A reference that
was measured is that very structure: between the two tests only its temperature and how it is held are others, and each
model holds the noise of its records.
"""

from math import log

import numpy as np
from numpy.typing import NDArray

from modallab.core.model import ModalModel
from modallab.core.rig import Rig

Real = NDArray[np.float64]

WARMTH = 0.002
"""Relative change of all stiffness together: aluminium and steel, some degrees."""
MASS = 0.001
"""Relative change of all mass together: moisture, what lies on it."""
PLACE = 0.002
"""How stiffness and mass differ from place to place: how it is held, and cables."""
DAMPING = 0.15
"""Relative change of a damping ratio: cables, clamps, the air."""


def of_structure(
    reference: ModalModel, bench: ModalModel, rig: Rig, wide: float = 1.0
) -> tuple[float, float, Real, Real]:
    """Deviations of all stiffness, of all mass, of each of its places (modes, modes), and of each damping (modes,).

    Relative; of damping that of its logarithm. By the rig's tolerances where the reference was computed. Places and
    damping differ by a factor `wide` more.
    """
    t, modes = rig.tolerance, reference.n_modes
    if not np.all(np.isfinite(reference.frequency_sigma_hz)):
        of_place = np.full((modes, modes), wide * np.hypot(t.stiffness_field, t.mass_field))
        as_guessed = np.full(modes, wide * log(rig.damping_ratio.factor))
        return np.hypot(t.youngs_modulus, 3 * t.thickness), np.hypot(t.density, t.thickness), of_place, as_guessed
    noise = _noise(reference, bench)
    of_place = np.full((modes, modes), wide * PLACE)
    of_place[np.diag_indices(modes)] = np.hypot(wide * PLACE, 2 * noise)
    damping = np.hypot(wide * DAMPING, np.nan_to_num(reference.damping_sigma / reference.damping_ratio))
    return WARMTH, MASS, of_place, damping


def _noise(reference: ModalModel, bench: ModalModel) -> Real:
    """(modes,) relative deviation between the frequencies of two models by their own sigmas."""
    own = np.nan_to_num(reference.frequency_sigma_hz / reference.frequency_hz)
    other = np.nan_to_num(bench.frequency_sigma_hz / bench.frequency_hz)
    return np.asarray(np.hypot(own, np.median(other) if other.size else 0.0))
