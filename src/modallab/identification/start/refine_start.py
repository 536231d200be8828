"""Rough start poles of a few lines, moved to where they explain the FRF best.

An estimator of few lines puts a mode beyond the last of them upon it. The search for the likelihood's maximum may then
end in a valley of its own: the pole low by a percent, and what stands in for the modes above where that mode should be.
"""

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.core.frf import Frf
from modallab.identification.likelihood.derivatives import poles_of
from modallab.identification.start.missed_modes import GAIN, misfit_of_trials

STEPS = (0.01, 0.5)
"""First steps, relative in frequency and logarithmic in damping."""
HALVINGS = 7
ZETA_RANGE = (1e-4, 0.1)
AROUND = np.array([(f, z) for f in (-1, 0, 1) for z in (-1, 0, 1) if f or z], dtype=np.float64)


def polish_poles(frf: Frf, poles: Complex128, band_hz: tuple[float, float]) -> Complex128:
    """The poles at the least misfit near them, if it is much less than theirs; else the poles as they are.

    Misfit is that of `add_missing_poles`. The FRF holds what still decays in the blocks too: a small gain says nothing.
    One pole after the other steps to the best of the eight places around it; where none is better, the steps halve.

    Args:
        frf: few lines, one or more inputs.
        poles: (modes,) rad/s.
        band_hz: where they stay.
    """
    if not poles.size:
        return poles
    at = np.stack([np.log(np.abs(poles)), np.log(np.clip(-poles.real / np.abs(poles), *ZETA_RANGE))])
    first = float(misfit_of_trials(frf, poles[None])[0])
    left = float(misfit_of_trials(frf, _poles(at)[None])[0])
    step = np.array(STEPS)
    for _ in range(HALVINGS):
        before = np.inf
        while left < 0.99 * before:
            before = left
            for mode in range(poles.size):
                at, left = _best_step(frf, at, left, mode, step, band_hz)
        step = step / 2
    return _poles(at) if left * GAIN < first else poles


def _best_step(
    frf: Frf, at: Real, left: float, mode: int, step: Real, band_hz: tuple[float, float]
) -> tuple[Real, float]:
    """Parameters with the least misfit among steps of one pole's frequency and damping, and that misfit."""
    trials = np.repeat(at[None], len(AROUND), axis=0)
    trials[:, :, mode] += AROUND * step
    trials[:, 0, mode] = np.clip(trials[:, 0, mode], *np.log(2 * np.pi * np.array(band_hz)))
    trials[:, 1, mode] = np.clip(trials[:, 1, mode], *np.log(ZETA_RANGE))
    found = misfit_of_trials(frf, np.stack([_poles(trial) for trial in trials]))
    best = int(np.argmin(found))
    return (trials[best], float(found[best])) if found[best] < left else (at, left)


def _poles(at: Real) -> Complex128:
    return poles_of(*np.exp(at))
