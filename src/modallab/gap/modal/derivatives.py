"""By how much each free number moves the predicted FRFs."""

import numpy as np

from modallab.core.arrays import Complex
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.state import State

SMALL = 1e-6
"""Relative step of a difference."""


def derivatives(c: Compared, state: State, sizes: tuple[int, ...]) -> Complex:
    """(numbers, lines, outputs, inputs) by each number in its own unit, in the order of `Free.sizes`.

    With D^-1 = F the receptance is X Y less what stands between: X = Phi_out F (lines, outputs, modes) and
    Y = F Phi_in^T (lines, modes, inputs), both with the gains, so that dH = -X dD Y.
    """
    s, known = c.s, state.structure
    omega, modes = known.omega, known.omega.size
    scale = known.stiffness, known.mass
    outside, by_mass = c.outside.scaled(*scale), c.outside.slope(*scale)
    x, y, whole = state.paths(s, outside)
    moved = [(state.paths(s, outside + SMALL * by)[2] - whole) / SMALL for by in (-outside - by_mass, by_mass)]
    read = state.read(s)[:, :, None]
    moved = [read * of * state.applied for of in moved]
    x, y, whole = read * x, y * state.applied, read * whole * state.applied
    squared = (s**2)[:, None, None]
    found = np.zeros((sum(sizes), *whole.shape), np.complex128)
    parts = np.split(found, np.cumsum(sizes)[:-1])
    stiff, mass, field, damping, gains, force, hits, at, struck, masses, across = parts
    for n, (r, q) in enumerate(zip(*np.triu_indices(modes), strict=True)):
        field[n] = x[:, :, r, None] * y[:, None, q, :]
        if r != q:
            field[n] += x[:, :, q, None] * y[:, None, r, :]
        field[n] *= -omega[r] * omega[q]
    for n, (r, q) in enumerate(c.close_pairs):
        size = 2 * np.sqrt(known.zeta[r] * omega[r] * known.zeta[q] * omega[q])
        pair = x[:, :, r, None] * y[:, None, q, :] + x[:, :, q, None] * y[:, None, r, :]
        across[n] = -size * s[:, None, None] * pair
    damped = 2 * np.sqrt(known.stiffness * known.mass) * known.zeta * omega
    for r in range(modes):
        damping[r] = -damped[r] * s[:, None, None] * (x[:, :, r, None] * y[:, None, r, :])
    stiff[0] = moved[0] - known.stiffness * (x * omega**2 @ y) + damping.sum(axis=0) / 2
    mass[0] = moved[1] - known.mass * squared * (x @ y) + damping.sum(axis=0) / 2
    force[0] = -whole
    for o in range(len(state.out)):
        gains[o, :, o] = whole[:, o]
        at[2 * o : 2 * o + 2, :, o] = read[:, o] * np.einsum("jm,lmi->jli", c.response_slopes[o], y)
    for i in range(len(state.into)):
        hits[i, :, :, i] = whole[:, :, i]
        ways = c.force_slopes.shape[1]
        struck[ways * i : ways * (i + 1), :, :, i] = state.applied[i] * (x @ c.force_slopes[i].T).transpose(2, 0, 1)
    before, after = x @ known.sensor_shapes.T, known.sensor_shapes @ y
    for p in range(len(known.sensor_masses)):
        masses[p] = -squared * before[:, :, p, None] * after[:, None, p, :]
    return found
