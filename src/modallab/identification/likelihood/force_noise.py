"""The force channel's noise within a hit, sample by sample, as part of what is searched.

Every sample of the measured hit is off by a little, and the modes ring with that for the whole block: no noise on the
responses looks like it, and no single modal state does either, for the hit lasts. Each sample's error is a parameter
with the force channel's noise as its prior. By sample m of block b output o changes by

    H_o(omega) w^m - sum over poles of R_o lambda^p dt z^(N - m) / (1 - z w),

the block's own closed form (see `excitation`) for a unit force at m.
Source: errors in the variables after Pintelon and Schoukens, "System Identification", 2nd ed. (2012), section 8.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.excitation import BlockLines, Excitation, HitExcitation
from modallab.identification.likelihood.orthonormal import complex_lines, stack_lines
from modallab.identification.likelihood.projection import InputSolution, LikelihoodPoint, LikelihoodProblem


@dataclass(frozen=True, eq=False, slots=True)
class _SharedColumns:
    """What all hits at one input share, outputs in noise units.

    Attributes:
        poles: (2 modes,) both of every pair.
        grid: lines and samples of every block.
        frf: (lines, outputs).
        tail: (lines, 2 modes) what each pole carries beyond the block's end, per residue.
        residues: (2 modes, outputs).
    """

    poles: NDArray[np.complex128]
    grid: BlockLines
    frf: NDArray[np.complex128]
    tail: NDArray[np.complex128]
    residues: NDArray[np.complex128]


class ForceWindow:
    """Slopes by the force at each sample of a stretch that several blocks of one input share.

    What a force at a sample does is the same in every block: hits a few samples apart differ by where they begin.
    By output o, line l and sample w a slope is F[l, o] turn[l, w] - sum over poles of tail[l, p] R[p, o] left[p, w].
    Sums over outputs and lines are taken over F, tail and R: their cost does not grow with outputs times samples.

    Args:
        samples: of the stretch.
        structure: what all hits at the input share.

    Attributes:
        first: sample.
    """

    def __init__(self, samples: NDArray[np.int64], structure: _SharedColumns) -> None:
        grid = structure.grid
        self.first, self._structure = int(samples[0]), structure
        self._turn = np.exp(-1j * np.outer(grid.omega * grid.dt, samples))
        self._left = np.exp(np.outer(structure.poles, (grid.n - samples) * grid.dt))

    @cached_property
    def slopes(self) -> Real:
        """(rows, outputs, samples) in noise units, each line's real part above its imaginary part."""
        of = self._structure
        value = of.frf[:, :, None] * self._turn[:, None, :]
        carried = of.tail[:, None, :] * of.residues.T
        value -= (carried.reshape(-1, len(self._left)) @ self._left).reshape(value.shape)
        return stack_lines(value)

    @cached_property
    def gram(self) -> Real:
        """(samples, samples) products of the slopes."""
        of, turn, left = self._structure, self._turn, self._left
        energy = np.sum(of.frf.real**2 + of.frf.imag**2, axis=1)
        among = (turn.conj().T * energy) @ turn
        mixed = turn.conj().T @ (of.tail * (of.frf.conj() @ of.residues.T)) @ left
        behind = left.conj().T @ ((of.tail.conj().T @ of.tail) * (of.residues.conj() @ of.residues.T)) @ left
        return (among - mixed - mixed.conj().T + behind).real

    def products(self, vectors: Real, weights: Real) -> Real:
        """(vectors, samples) of (rows, vectors) with the slopes, outputs summed by (vectors, outputs) weights."""
        of, lines = self._structure, complex_lines(vectors).conj()
        ahead = (lines * (weights @ of.frf.T)) @ self._turn
        return (ahead - ((lines @ of.tail) * (weights @ of.residues.T)) @ self._left).real


@dataclass(frozen=True, eq=False, slots=True)
class ForceParts:
    """Slopes of one input's blocks by their force samples, in noise units.

    Attributes:
        windows: per member the stretch its hit lies in.
        places: per member where its own samples lie in that stretch.
        all_on_q: per member Q^T slopes of the whole stretch (columns, outputs, samples).
    """

    windows: tuple[ForceWindow, ...]
    places: tuple[slice, ...]
    all_on_q: tuple[Real, ...]

    @property
    def slopes(self) -> tuple[Real, ...]:
        """Slopes by the force samples of each hit, (rows, outputs, width)."""
        return tuple(w.slopes[..., place] for w, place in zip(self.windows, self.places, strict=True))

    @property
    def slopes_in_columns(self) -> tuple[Real, ...]:
        """Per member Q^T slopes (columns, outputs, width)."""
        return tuple(part[..., place] for part, place in zip(self.all_on_q, self.places, strict=True))


def force_parts(problem: LikelihoodProblem, point: LikelihoodPoint, group: InputSolution) -> ForceParts:
    """See ForceParts."""
    rows, width = group.columns[0].phi.shape[0], point.parameters.force.shape[1]
    firsts = [_require_hit(problem.blocks[i].excitation).first for i in group.members]
    windows = _force_windows(firsts, width, _shared_columns(problem, point, group))
    places = tuple(slice(f - w.first, f - w.first + width) for f, w in zip(firsts, windows, strict=True))
    on_q = tuple(
        (group.q[m * rows : (m + 1) * rows].T @ w.slopes.reshape(rows, -1)).reshape(-1, *w.slopes.shape[1:])
        for m, w in enumerate(windows)
    )
    return ForceParts(windows, places, on_q)


def _shared_columns(problem: LikelihoodProblem, point: LikelihoodPoint, group: InputSolution) -> _SharedColumns:
    at, grid = point.parameters, _require_hit(problem.blocks[group.members[0]].excitation).grid
    poles = poles_of(at.omega, at.zeta)
    n = 2 * poles.size
    coefficients = group.coefficients / point.noise
    parts = coefficients[:n].reshape(poles.size, 2, -1)
    residue = parts[:, 0] + 1j * parts[:, 1]
    both, residues = np.concatenate([poles, poles.conj()]), np.concatenate([residue, residue.conj()])
    s = 1j * grid.omega[:, None]
    frf = s**grid.p * ((1 / (s - both)) @ residues)
    for power, term in zip(problem.powers, coefficients[n:], strict=True):
        frf = frf + s ** (grid.p + power) * term
    tail = both**grid.p * grid.dt / (1 - np.exp((both - s) * grid.dt))
    return _SharedColumns(both, grid, frf, tail, residues)


def _force_windows(firsts: Sequence[int], width: int, structure: _SharedColumns) -> tuple[ForceWindow, ...]:
    """The stretch of each hit: one for all, unless they lie so far apart that it would cost more than it saves."""
    begin, end = min(firsts), max(firsts) + width
    if end - begin <= 2 * width:
        return (ForceWindow(np.arange(begin, end), structure),) * len(firsts)
    return tuple(ForceWindow(first + np.arange(width), structure) for first in firsts)


def _require_hit(excitation: Excitation) -> HitExcitation:
    if not isinstance(excitation, HitExcitation):
        raise TypeError("only a hit has force samples")
    return excitation


def force_equations(
    problem: LikelihoodProblem, point: LikelihoodPoint, group: InputSolution, others: tuple[Real, Real]
) -> tuple[Real, Real]:
    """J^T J and J^T residual of one input: poles, its members' states, then its members' force samples.

    Args:
        problem: data and structure.
        point: where.
        group: the input.
        others: the same of poles and states alone.
    """
    parts = force_parts(problem, point, group)
    width = point.parameters.force.shape[1]
    n_others, rows = len(others[1]), group.columns[0].phi.shape[0]
    projected = np.concatenate([b.reshape(-1, width) for b in parts.slopes_in_columns], axis=1)
    matrix = np.zeros((n_others + projected.shape[1],) * 2)
    gradient = np.zeros(len(matrix))
    matrix[:n_others, :n_others], gradient[:n_others] = others
    matrix[n_others:, n_others:] = -projected.T @ projected
    vectors = _PoleVectors(group, point.noise)
    for m, (window, own, on_q) in enumerate(zip(parts.windows, parts.places, parts.all_on_q, strict=True)):
        here, place = slice(m * rows, (m + 1) * rows), slice(n_others + m * width, n_others + (m + 1) * width)
        matrix[place, place] += window.gram[own, own]
        residual = group.residual[here] / point.noise
        gradient[place] = window.products(residual, np.eye(residual.shape[1])).sum(axis=0)[own]
        matrix[:n_others, place] = vectors.across(m, window, on_q)[:, own]
        matrix[place, :n_others] = matrix[:n_others, place].T
    return matrix, gradient


class _PoleVectors:
    """The derivative vectors of poles and states of one input, to be multiplied with slopes by force samples."""

    def __init__(self, group: InputSolution, noise: Real) -> None:
        found, rows = group.columns, group.columns[0].phi.shape[0]
        self._columns, self._n_poles = found, found[0].poles.values.shape[1]
        self._width = found[0].local.parameter.size
        q = [group.q[m * rows : (m + 1) * rows] for m in range(len(found))]
        poles = np.sum([part.T @ c.poles.values for part, c in zip(q, found, strict=True)], axis=0)
        states = [part.T @ c.local.values for part, c in zip(q, found, strict=True)] if self._width else []
        self._on_q: Real = np.concatenate([poles, *states], axis=1)
        self._column = np.concatenate([found[0].poles.column, *[c.local.column for c in found]])
        self._weights = group.coefficients / noise
        firsts = np.flatnonzero(np.diff(found[0].poles.parameter, prepend=-1))
        own = np.flatnonzero(np.diff(found[0].local.parameter, prepend=-1))
        begin = [self._n_poles + m * self._width + own for m in range(len(found))]
        self._starts = np.concatenate([firsts, *begin]) if self._width else firsts

    def across(self, member: int, window: ForceWindow, on_q: Real) -> Real:
        """J^T J (poles and states, samples) with the force samples of one member's window."""
        found = self._columns[member]
        # Vectors of one column are weighed alike: the outputs are summed before the many vectors come in.
        weighed = np.tensordot(self._weights, on_q, axes=(1, 1))
        product = -np.einsum("kv,vkw->vw", self._on_q, weighed[self._column], optimize=True)
        product[: self._n_poles] += window.products(found.poles.values, self._weights[found.poles.column])
        if self._width:
            begin = self._n_poles + member * self._width
            product[begin : begin + self._width] += window.products(
                found.local.values, self._weights[found.local.column]
            )
        return np.add.reduceat(product, self._starts, axis=0)
