"""Derivatives of a block's columns by everything that is searched: poles, unknown states, and the drive's error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.excitation import Excitation, Lines
from modallab.identification.likelihood.orthonormal import real_rows

Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class DerivativeVectors:
    """Derivatives of columns.

    The derivative of output o by parameter i is the sum over its vectors of value * C[column, o].

    Attributes:
        values: (rows, vectors), ordered by parameter.
        parameter: (vectors,) which parameter.
        column: (vectors,) which column's coefficient multiplies it.
    """

    values: Real
    parameter: Index
    column: Index


@dataclass(frozen=True, eq=False, slots=True)
class HalfOfPair:
    """What belongs to one of a pole pair, each (modes, lines)."""

    forced: Lines
    slope: Lines
    free: Lines
    free_slope: Lines


def pole_vectors(
    omega: Real, zeta: Real, halves: tuple[HalfOfPair, HalfOfPair], start: NDArray[np.complex128]
) -> DerivativeVectors:
    """By omega and zeta, mode by mode; `start` (modes,) is the unknown state."""
    up, down = halves
    slope_up = up.slope + start[:, None] * up.free_slope
    slope_down = down.slope + start.conj()[:, None] * down.free_slope
    rates = (poles_of(omega, zeta) / omega, -omega - 1j * omega * zeta / np.sqrt(1 - zeta**2))
    values = np.stack(
        [columns_of_residue(slope_up * r[:, None], slope_down * r.conj()[:, None]) for r in rates], axis=1
    )
    mode = np.repeat(np.arange(len(omega)), 4)
    which = np.tile([0, 0, 1, 1], len(omega))
    part = np.tile([0, 1, 0, 1], len(omega))
    return DerivativeVectors(real_rows(values.reshape(-1, values.shape[-1])), 2 * mode + which, 2 * mode + part)


def columns_of_residue(up: Lines, down: Lines) -> Lines:
    """(modes, 2, lines): what the real and the imaginary part of the residue multiply, R up + conj(R) down."""
    return np.stack([up + down, 1j * (up - down)], axis=1)


def residual_term_columns(excitation: Excitation, powers: Sequence[int]) -> Lines:
    """(powers, lines): the residual terms' columns."""
    if not powers:
        return np.zeros((0, excitation.static(0).size), complex)
    return np.stack([excitation.static(power) for power in powers])


def state_vectors(up: Lines, down: Lines) -> DerivativeVectors:
    """By both parts of every mode's unknown state."""
    u, v = np.moveaxis(columns_of_residue(up, down), 1, 0)
    n_modes = len(up)
    values = np.stack([u, v, v, -u], axis=1).reshape(4 * n_modes, -1)
    mode = np.repeat(np.arange(n_modes), 4)
    return DerivativeVectors(
        real_rows(values), 2 * mode + np.tile([0, 0, 1, 1], n_modes), 2 * mode + np.tile([0, 1, 0, 1], n_modes)
    )


def drive_vectors(
    excitation: Excitation, poles: NDArray[np.complex128], powers: Sequence[int], *, first: int
) -> DerivativeVectors:
    """By both parts of the drive's relative error, which are parameters `first` and the next."""
    found: list[Lines] = []
    for turned in (excitation, excitation.scaled(1j)):
        pairs = columns_of_residue(turned.forced(poles)[0], turned.forced(poles.conj())[0])
        found.append(np.concatenate([pairs.reshape(-1, pairs.shape[-1]), residual_term_columns(turned, powers)]))
    n = len(found[0])
    return DerivativeVectors(real_rows(np.concatenate(found)), first + np.repeat([0, 1], n), np.tile(np.arange(n), 2))


def join_vectors(parts: Sequence[DerivativeVectors]) -> DerivativeVectors:
    """All of them as one."""
    if len(parts) == 1:
        return parts[0]
    if not parts:
        return DerivativeVectors(np.zeros((0, 0)), np.zeros(0, np.int64), np.zeros(0, np.int64))
    return DerivativeVectors(
        np.concatenate([p.values for p in parts], axis=1),
        np.concatenate([p.parameter for p in parts]),
        np.concatenate([p.column for p in parts]),
    )


def poles_of(omega: Real, zeta: Real) -> NDArray[np.complex128]:
    """Poles lambda = -zeta omega + j omega sqrt(1 - zeta^2), in rad/s."""
    return -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
