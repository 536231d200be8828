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


def floor_of_structure(reference: ModalModel, bench: ModalModel, rig: Rig) -> tuple[Real, Real]:
    """Deviations of all stiffness, all mass, each of its places (upper triangle of modes), and each damping (modes,).

    Relative; of damping that of its logarithm.

    Returns:
        (numbers,) what the rig's tolerances say, and (numbers,) what both models are off by.
    """
    t, modes = rig.tolerance, reference.n_modes
    usual = _usual(bench.frequency_sigma_hz, bench.frequency_hz), _usual(bench.damping_sigma, bench.damping_ratio)
    frequency = np.hypot(_share(reference.frequency_sigma_hz, reference.frequency_hz), usual[0])
    places, of_places = np.full(modes * (modes + 1) // 2, np.hypot(t.stiffness_field, t.mass_field)), np.diag(frequency)
    of_damping = np.hypot(_share(reference.damping_sigma, reference.damping_ratio), usual[1])
    whole = np.hypot(t.youngs_modulus, 3 * t.thickness), np.hypot(t.density, t.thickness)
    # E of a model that was computed is a guess: what it explains is no change at a place.
    guessed = GUESSED if reference.method == COMPUTED else 0.0
    tolerances = np.concatenate([whole, places, np.full(modes, log(rig.damping_ratio.factor))])
    return tolerances, np.concatenate([(guessed, 0.0), 2 * of_places[np.triu_indices(modes)], of_damping])


def _share(sigma: Real, of: Real) -> Real:
    """Relative sigmas; 0 where none is known."""
    return np.where(np.isfinite(sigma), sigma, 0.0) / of


def _usual(sigma: Real, of: Real) -> float:
    """Median relative sigma."""
    return float(np.median(_share(sigma, of))) if of.size else 0.0
