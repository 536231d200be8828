"""Rough start poles of a few lines, moved to where they explain the FRF best.

An estimator of few lines puts a mode beyond the last of them upon it. The search for the likelihood's maximum may then
end in a valley of its own: the pole low by a percent, and what stands in for the modes above where that mode should be.
"""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.frf import DERIVATIVES, Frf
from modallab.identification.likelihood.basis import poles_of

GRID = 400
ZETAS = (0.003, 0.006, 0.012)
GAIN = 3.0
"""One more pole must divide the squared misfit by this; noise and decaying blocks leave less to gain."""
MOST = 4
APART = 0.2
"""No second pole this near to another, as a share of its frequency: few lines cannot distinguish the two."""
POWERS = (0, 2, 4)


def add_missing_poles(frf: Frf, poles: NDArray[np.complex128], band_hz: tuple[float, float]) -> NDArray[np.complex128]:
    """The poles, and up to four more, each where it lowers the misfit most, while it lowers it much.

    Misfit is relative to each line's level, so that a resonance does not outweigh all other lines.

    Args:
        frf: few lines, one or more inputs.
        poles: (modes,) start poles, rad/s.
        band_hz: where to look.
    """
    frequency = np.geomspace(band_hz[0], band_hz[1], GRID)
    omega = 2 * np.pi * np.repeat(frequency, len(ZETAS))
    zeta = np.tile(ZETAS, GRID)
    candidates = poles_of(omega, zeta)
    found = poles
    left = float(misfit_of_trials(frf, found[None])[0])
    for _ in range(MOST):
        apart = np.abs(candidates.imag[:, None] / found.imag - 1).min(axis=1, initial=np.inf) > APART
        free = candidates[apart]
        if free.size == 0:
            break
        trials = np.concatenate([np.broadcast_to(found, (free.size, found.size)), free[:, None]], axis=1)
        each = misfit_of_trials(frf, trials)
        best = int(np.argmin(each))
        if each[best] * GAIN > left:
            break
        found, left = trials[best], float(each[best])
    return found


def misfit_of_trials(frf: Frf, trials: NDArray[np.complex128]) -> Real:
    """Squared misfit (trials,) of each set of poles, residues and residual terms solved for.

    Args:
        frf: few lines, one or more inputs.
        trials: (trials, modes) rad/s.
    """
    s = 2j * np.pi * frf.frequency_hz
    p = DERIVATIVES[frf.quantity]
    up, down = s**p / (s - trials[..., None]), s**p / (s - trials.conj()[..., None])
    static = np.broadcast_to(np.stack([s ** (p + power) for power in POWERS]), (len(trials), len(POWERS), s.size))
    columns = np.concatenate([up + down, 1j * (up - down), static], axis=1)
    level = np.sqrt(np.mean(np.abs(frf.values) ** 2, axis=(0, 1)))
    basis = np.concatenate([(columns / level).real, (columns / level).imag], axis=-1)
    basis = np.moveaxis(basis / np.linalg.norm(basis, axis=-1, keepdims=True), -1, -2)
    values = (frf.values / level).reshape(-1, s.size)
    response = np.concatenate([values.real, values.imag], axis=-1).T
    q, _ = np.linalg.qr(basis)
    return np.sum(response**2) - np.sum((np.swapaxes(q, -1, -2) @ response) ** 2, axis=(1, 2))


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
