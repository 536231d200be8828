"""The force channel's noise within a blow, sample by sample, as part of what is searched.

Every sample of the measured blow is off by a little, and the modes ring with that for the whole block: no noise on the
responses looks like it, and no single modal state does either, for the blow lasts. Each sample's error is a parameter
with the force channel's noise as its prior. By sample m of block b output o changes by

    H_o(omega) w^m - sum over poles of R_o lambda^p dt z^(N - m) / (1 - z w),

the block's own closed form (see `excitation`) for a unit force at m.
Source: errors in the variables after Pintelon and Schoukens, "System Identification", 2nd ed. (2012), section 8.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.identification.basis import poles_of
from modallab.identification.excitation import BlowExcitation
from modallab.identification.projection import GroupSolution, Point, Problem

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True)
class ForceParts:
    """Slopes of one input's blocks by their force samples, in noise units.

    Attributes:
        slopes: per member (rows, outputs, width).
        on_q: per member Q^T slopes (columns, outputs, width).
    """

    slopes: tuple[Real, ...]
    on_q: tuple[Real, ...]


def force_parts(problem: Problem, point: Point, group: GroupSolution) -> ForceParts:
    """See ForceParts."""
    rows = group.columns[0].phi.shape[0]
    slopes = tuple(_slopes(problem, point, group, i) / point.noise[None, :, None] for i in group.members)
    on_q = tuple(
        (group.q[m * rows : (m + 1) * rows].T @ part.reshape(rows, -1)).reshape(-1, *part.shape[1:])
        for m, part in enumerate(slopes)
    )
    return ForceParts(slopes, on_q)


def _slopes(problem: Problem, point: Point, group: GroupSolution, block: int) -> Real:
    """(rows, outputs, width), real parts on imaginary parts."""
    excitation, width = problem.blocks[block].excitation, point.parameters.force.shape[1]
    if not isinstance(excitation, BlowExcitation):
        raise TypeError("only a blow has force samples")
    grid, at = excitation.grid, point.parameters
    poles = poles_of(at.omega, at.zeta)
    n = 2 * poles.size
    parts = group.coefficients[:n].reshape(poles.size, 2, -1)
    residue = parts[:, 0] + 1j * parts[:, 1]
    both, residues = np.concatenate([poles, poles.conj()]), np.concatenate([residue, residue.conj()])
    s, sample = 1j * grid.omega, excitation.first + np.arange(width)
    frf = s[:, None] ** grid.p * ((1 / (s[:, None] - both)) @ residues)
    for power, term in zip(problem.powers, group.coefficients[n:], strict=True):
        frf = frf + s[:, None] ** (grid.p + power) * term
    turn = np.exp(-1j * np.outer(grid.omega * grid.dt, sample))
    tail = both**grid.p * grid.dt / (1 - np.exp((both - s[:, None]) * grid.dt))
    left = np.exp(np.outer(both, (grid.n - sample) * grid.dt))
    carried = (tail[:, None, :] * residues.T).reshape(-1, both.size) @ left
    value = frf[:, :, None] * turn[:, None, :] - carried.reshape(s.size, -1, width)
    return np.concatenate([value.real, value.imag])


def force_equations(
    problem: Problem, point: Point, group: GroupSolution, poles: tuple[Real, Real]
) -> tuple[Real, Real]:
    """J^T J and J^T residual of one input, poles first, then its members' force samples.

    Args:
        problem: data and structure.
        point: where.
        group: the input.
        poles: the same of the poles alone.
    """
    parts = force_parts(problem, point, group)
    width = point.parameters.force.shape[1]
    n_poles, rows = len(poles[1]), group.columns[0].phi.shape[0]
    projected = np.concatenate([b.reshape(-1, width) for b in parts.on_q], axis=1)
    matrix = np.zeros((n_poles + projected.shape[1],) * 2)
    gradient = np.zeros(len(matrix))
    matrix[:n_poles, :n_poles], gradient[:n_poles] = poles
    matrix[n_poles:, n_poles:] = -projected.T @ projected
    found = group.columns[0].poles
    starts = np.flatnonzero(np.diff(found.parameter, prepend=-1))
    weighted = (group.coefficients / point.noise)[found.column]
    members = enumerate(group.columns)
    on_q = np.sum([group.q[m * rows : (m + 1) * rows].T @ c.poles.values for m, c in members], axis=0)
    for m, (part, own) in enumerate(zip(parts.slopes, parts.on_q, strict=True)):
        here, place = slice(m * rows, (m + 1) * rows), slice(n_poles + m * width, n_poles + (m + 1) * width)
        flat = part.reshape(-1, width)
        matrix[place, place] += flat.T @ flat
        gradient[place] = flat.T @ (group.residual[here] / point.noise).ravel()
        across = group.columns[m].poles.values.T @ part.reshape(rows, -1) - on_q.T @ own.reshape(len(own), -1)
        across = np.einsum("vow,vo->vw", across.reshape(len(weighted), -1, width), weighted)
        matrix[:n_poles, place] = np.add.reduceat(across, starts, axis=0)
        matrix[place, :n_poles] = matrix[:n_poles, place].T
    return matrix, gradient
