"""Modes that a rough start has missed: where one more pole explains most of what an FRF's fit leaves over."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.frf import DERIVATIVES, Frf
from modallab.identification.likelihood.derivatives import poles_of

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
