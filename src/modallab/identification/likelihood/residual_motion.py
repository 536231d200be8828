"""What may be left of earlier hits at a block's start: motion that the sensors' noise hides.

A beam that looks at rest need not be. The slowest mode may still move as much as one sample's noise and not be seen
before the hit, yet hundreds of samples after it give its phase to a hundredth of that. How long the last hit is ago
at least follows from that mode, and how much of all others can be left then from their decay: hardly anything, as a
rule.
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.identification.likelihood.derivatives import poles_of
from modallab.identification.likelihood.excitation import BlockLines
from modallab.identification.likelihood.fit import LikelihoodFit

LEAST = 1e-9
"""Share of the impulse; a prior of zero would divide by zero."""


def residual_motion_sigma(fit: LikelihoodFit, grid: BlockLines, impulse: Real) -> Real:
    """Prior (blocks, modes) in N s of each part of every mode's state at a block's start.

    Args:
        fit: of the blocks as if they began at rest.
        grid: of the blocks.
        impulse: (blocks,) N s of each hit.
    """
    at = fit.point.parameters
    poles = poles_of(at.omega, at.zeta)
    constants, _ = fit.modal_constants
    residue = np.abs(constants) / (2 * poles.imag[:, None, None])
    # (modes, inputs): rms over outputs and time of the motion that a unit state is.
    motion = np.sqrt(2 * np.mean(residue**2, axis=1)) * np.abs(poles[:, None]) ** grid.p
    noise = float(np.sqrt(np.mean(fit.point.noise**2) * 2 / grid.n))
    struck = float(impulse.max()) * motion.max(axis=1)
    decay = at.zeta * at.omega
    slowest = int(np.argmin(np.where(struck > noise, decay, np.inf)))
    ago = max(0.0, float(np.log(struck[slowest] / noise))) / max(float(decay[slowest]), 1e-12)
    left = np.minimum(struck, noise) if ago == 0.0 else struck * np.exp(-decay * ago)
    group = np.array([block.group for block in fit.problem.blocks])
    unit = np.maximum(motion, np.finfo(float).tiny)
    sigma = left[:, None] / unit
    return np.maximum(sigma.T[group], LEAST * impulse[:, None])
