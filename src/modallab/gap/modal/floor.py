"""By how much two tests of one structure differ though nothing was changed: the rig's tolerances, at most.

How much less it is, where the reference was measured, is inferred with everything else (`judged`). Each model holds
the noise of its records besides.
"""

from math import log

import numpy as np
from numpy.typing import NDArray

from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.updating.elements import COMPUTED

Real = NDArray[np.float64]


GUESSED = 0.1
"""Deviation of the stiffness of a computed reference as a whole."""


def of_structure(
    reference: ModalModel, bench: ModalModel, rig: Rig, wide: float = 1.0
) -> tuple[float, float, Real, Real]:
    """Deviations of all stiffness, of all mass, of each of its places (modes, modes), and of each damping (modes,).

    Relative; of damping that of its logarithm. All differ by a factor `wide` of what the rig's tolerances say.
    """
    t, modes = rig.tolerance, reference.n_modes
    frequency = np.hypot(_share(reference.frequency_sigma_hz, reference.frequency_hz), _usual(bench))
    of_place = np.full((modes, modes), wide * np.hypot(t.stiffness_field, t.mass_field))
    of_place[np.diag_indices(modes)] = np.hypot(np.diag(of_place), 2 * frequency)
    damping = np.hypot(wide * log(rig.damping_ratio.factor), _share(reference.damping_sigma, reference.damping_ratio))
    stiffness, mass = wide * np.hypot(t.youngs_modulus, 3 * t.thickness), np.hypot(t.density, t.thickness)
    # E of a model that was computed is a guess: what it explains is no change at a place.
    stiffness = np.hypot(stiffness, GUESSED if reference.method == COMPUTED else 0.0)
    return float(stiffness), wide * mass, of_place, damping


def _share(sigma: Real, of: Real) -> Real:
    """Relative sigmas; 0 where none is known."""
    return np.where(np.isfinite(sigma), sigma, 0.0) / of


def _usual(bench: ModalModel) -> float:
    """Median relative sigma of its frequencies."""
    return float(np.median(_share(bench.frequency_sigma_hz, bench.frequency_hz))) if bench.n_modes else 0.0
