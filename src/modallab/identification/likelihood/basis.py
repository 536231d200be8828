"""Columns of the modal model in a block for given poles, out-of-band ones among them, and their derivatives."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.excitation import (
    BlockLines,
    Excitation,
    HitExcitation,
    Lines,
    PoleKernel,
    kernel_of_poles,
)
from modallab.identification.likelihood.orthonormal import real_rows

RESIDUAL_POWERS = (-2, 0, 2, 4)
"""Powers of s for what modes outside the band leave. -2 in a receptance is an acceleration like the force itself, as
modes below the band leave it. So do, a little, far modes that are sampled too slowly, and cross-talk. Left out, it
passes for damping of the lowest mode."""
STAND_INS = (1.05,)
"""A pole that begins at this multiple of the upper edge stands for the modes above."""
STAND_IN_SHARE = 0.4
"""The stand-ins are damped as the band's own modes are, give or take this share. The band's lines hardly say: left to
them a damping ratio runs to zero, where a pole rings through the whole block. But it turns the phase of all that lies
below, so that a wrong one that is held too fast makes the upper modes' constants wrong."""


@dataclass(frozen=True, eq=False, slots=True)
class StartPoles:
    """Where a search begins.

    Attributes:
        omega: (poles,) rad/s; the last `stand_ins` stand for modes above the band.
        zeta: (poles,)
        zeta_prior: (poles, 2) centre and sigma.
        stand_ins: how many.
    """

    omega: NDArray[np.float64]
    zeta: NDArray[np.float64]
    zeta_prior: NDArray[np.float64]
    stand_ins: int


def with_stand_ins(
    poles: NDArray[np.complex128], top_hz: float, multiples: tuple[float, ...], zeta_range: tuple[float, float]
) -> StartPoles:
    """Start poles, with stand-ins for the modes above the band appended.

    A power series in s converges slowly for a mode just above the band; a pole there, free to move, does better.

    Args:
        poles: (modes,) rad/s.
        top_hz: upper edge of the band.
        multiples: of the upper edge, where the stand-ins begin.
        zeta_range: damping ratios of the start poles are brought into this range.
    """
    omega = np.concatenate([np.abs(poles), 2 * np.pi * top_hz * np.array(multiples)])
    low, high = zeta_range
    zeta = np.clip(-poles.real / np.abs(poles), low, high)
    like_them = float(np.median(zeta))
    prior = np.tile([0.0, np.inf], (omega.size, 1))
    prior[poles.size :] = like_them, STAND_IN_SHARE * like_them
    zeta = np.append(zeta, np.full(len(multiples), like_them))
    return StartPoles(omega, zeta, prior, len(multiples))


def edges_of_stand_ins(omega: NDArray[np.float64], top_hz: float) -> tuple[float, ...]:
    """Multiples of the upper edge at which stand-ins begin again: where a fit has moved them to, if that is above.

    Args:
        omega: (poles,) rad/s of the fit, its stand-in last.
        top_hz: upper edge of the band.
    """
    moved = float(omega[-1]) / (2 * np.pi * top_hz)
    return STAND_INS if moved < 1 else (moved,)


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


@dataclass(frozen=True, eq=False, slots=True)
class LineBlock:
    """One block at its lines.

    Attributes:
        excitation: what drove it.
        response: (outputs, lines) DFT of the responses.
        group: which input (drive point) it belongs to.
    """

    excitation: Excitation
    response: NDArray[np.complex128]
    group: int


@dataclass(frozen=True, eq=False)
class BlockColumns:
    """Real columns of one block, each line's real part above its imaginary part (rows = 2 lines).

    Attributes:
        phi: (rows, columns): per mode what real and imaginary part of its residue multiply, then residual terms.
        derive: gives `poles` and `local`; a trial that is not kept is never asked.
    """

    phi: Real
    derive: Callable[[], tuple[DerivativeVectors, DerivativeVectors]]

    @cached_property
    def _derived(self) -> tuple[DerivativeVectors, DerivativeVectors]:
        return self.derive()

    @property
    def poles(self) -> DerivativeVectors:
        """Derivatives by omega and zeta, mode by mode."""
        return self._derived[0]

    @property
    def local(self) -> DerivativeVectors:
        """Derivatives by what the block alone has: parts of each mode's unknown state, then the drive's error."""
        return self._derived[1]


class SharedKernels:
    """What all blocks of one grid have in common at given poles: kernels, and free decays from the same sample."""

    def __init__(self, grid: BlockLines, poles: NDArray[np.complex128]) -> None:
        self._pair = poles, poles.conj()
        self._grid = grid
        self._kernels: tuple[PoleKernel, ...] = ()
        self._free: dict[int, tuple[tuple[Lines, Lines], ...]] = {}
        self._vectors: dict[int, DerivativeVectors] = {}

    def halves(self, excitation: Excitation, *, free: bool) -> tuple[HalfOfPair, HalfOfPair]:
        """Both of every pole pair in a block that this drove."""
        if isinstance(excitation, HitExcitation):
            self._kernels = self._kernels or tuple(kernel_of_poles(self._grid, p) for p in self._pair)
        kernels: tuple[PoleKernel | None, ...] = self._kernels or (None, None)
        forced = [excitation.forced(p, k) for p, k in zip(self._pair, kernels, strict=True)]
        if not free:
            nothing = np.zeros((1, 1), complex)
            return HalfOfPair(*forced[0], nothing, nothing), HalfOfPair(*forced[1], nothing, nothing)
        decays = self._free.get(excitation.state_at)
        if decays is None:
            decays = self._free[excitation.state_at] = tuple(excitation.free(p) for p in self._pair)
        return HalfOfPair(*forced[0], *decays[0]), HalfOfPair(*forced[1], *decays[1])

    def state_vectors(self, excitation: Excitation, up: HalfOfPair, down: HalfOfPair) -> DerivativeVectors:
        """Derivatives by the unknown states."""
        place = excitation.state_at
        if place not in self._vectors:
            self._vectors[place] = state_vectors(up.free, down.free)
        return self._vectors[place]


def columns_of_block(
    excitation: Excitation,
    omega: Real,
    zeta: Real,
    state: NDArray[np.complex128] | None,
    drive: complex | None,
    powers: Sequence[int],
    shared: SharedKernels | None = None,
) -> BlockColumns:
    """Columns of a block and their derivatives.

    Args:
        excitation: what drove the block.
        omega: (modes,) undamped natural frequencies, rad/s.
        zeta: (modes,) damping ratios.
        state: (modes,) unknown modal states, or None for a block that has none.
        drive: unknown relative error of the drive's complex amplitude, or None.
        powers: powers of s of the receptance's residual terms.
        shared: what blocks of one grid have in common at these poles, where several are requested.
    """
    poles = poles_of(omega, zeta)
    common = shared or SharedKernels(excitation.grid, poles)
    true_drive = excitation if drive is None else excitation.scaled(1 + drive)
    up, down = common.halves(true_drive, free=state is not None)
    start = np.zeros(len(omega), complex) if state is None else state
    value = columns_of_residue(up.forced + start[:, None] * up.free, down.forced + start.conj()[:, None] * down.free)
    phi = np.concatenate([value.reshape(-1, value.shape[-1]), residual_term_columns(true_drive, powers)])

    def derive() -> tuple[DerivativeVectors, DerivativeVectors]:
        local = [] if state is None else [common.state_vectors(excitation, up, down)]
        if drive is not None:
            local.append(drive_vectors(excitation, poles, powers, first=0 if state is None else 2 * len(omega)))
        return pole_vectors(omega, zeta, (up, down), start), join_vectors(local)

    return BlockColumns(real_rows(phi), derive)
