"""How the beam answers to a base that moves."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.matrices import OWN, stiffness_and_mass
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure


def base_transmission(structure: TwinStructure, x_m: Real, s: Complex) -> Complex:
    """(points, k) absolute acceleration at places on the beam per acceleration of the base, at s (k,).

    Relative motion is that under the inertia load -M 1 of the moving base.
    """
    modes = solve_modes(structure)
    _, mass = stiffness_and_mass(replace(structure, hung=()))
    rigid = np.zeros(OWN)
    rigid[0::2] = 1.0
    load = -(modes.columns.T @ (mass @ rigid))
    out = modes.at(x_m)
    relative = (out * load) @ (1 / (s - modes.poles[:, None]))
    relative = relative + (out * load).conj() @ (1 / (s - modes.poles.conj()[:, None]))
    return 1 + s**2 * relative
