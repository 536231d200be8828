"""By how much two tests of one structure differ though nothing was changed: the rig's tolerances, at most.

How much less it is, where the reference was measured, is inferred with everything else (`judged`). Each model holds
the noise of its records besides.
"""

from math import log

import numpy as np

from modallab.core.arrays import Real
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.updating.elements import COMPUTED

GUESSED = 0.1
"""Deviation of the stiffness of a computed reference as a whole."""


def floor_of_structure(
    reference: ModalModel, bench: ModalModel, rig: Rig, wide: float = 1.0
) -> tuple[float, float, Real, Real]:
    """Deviations of all stiffness, of all mass, of each of its places (modes, modes), and of each damping (modes,).

    Relative; of damping that of its logarithm. All differ by a factor `wide` of what the rig's tolerances say.
    """
    t, modes = rig.tolerance, reference.n_modes
    usual = _usual(bench.frequency_sigma_hz, bench.frequency_hz), _usual(bench.damping_sigma, bench.damping_ratio)
    frequency = np.hypot(_share(reference.frequency_sigma_hz, reference.frequency_hz), usual[0])
    of_place = np.full((modes, modes), wide * np.hypot(t.stiffness_field, t.mass_field))
    of_place[np.diag_indices(modes)] = np.hypot(np.diag(of_place), 2 * frequency)
    of_models = np.hypot(_share(reference.damping_sigma, reference.damping_ratio), usual[1])
    damping = np.hypot(wide * log(rig.damping_ratio.factor), of_models)
    stiffness, mass = wide * np.hypot(t.youngs_modulus, 3 * t.thickness), np.hypot(t.density, t.thickness)
    # E of a model that was computed is a guess: what it explains is no change at a place.
    stiffness = np.hypot(stiffness, GUESSED if reference.method == COMPUTED else 0.0)
    return float(stiffness), wide * mass, of_place, damping


def _share(sigma: Real, of: Real) -> Real:
    """Relative sigmas; 0 where none is known."""
    return np.where(np.isfinite(sigma), sigma, 0.0) / of


def _usual(sigma: Real, of: Real) -> float:
    """Median relative sigma."""
    return float(np.median(_share(sigma, of))) if of.size else 0.0
