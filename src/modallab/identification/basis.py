"""Columns of the modal model in a block, for given poles, and their derivatives by everything that is searched."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.identification.excitation import BlowExcitation, Excitation, Grid, Kernel, Lines, kernel

Real = NDArray[np.float64]
Index = NDArray[np.int64]


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


@dataclass(frozen=True, eq=False, slots=True)
class Vectors:
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


@dataclass(frozen=True, eq=False)
class BlockColumns:
    """Real columns of one block, each line's real part above its imaginary part (rows = 2 lines).

    Attributes:
        phi: (rows, columns): per mode what real and imaginary part of its residue multiply, then residual terms.
        derive: gives `poles` and `local`; a trial that is not kept is never asked.
    """

    phi: Real
    derive: Callable[[], tuple[Vectors, Vectors]]

    @cached_property
    def _derived(self) -> tuple[Vectors, Vectors]:
        return self.derive()

    @property
    def poles(self) -> Vectors:
        """Derivatives by omega and zeta, mode by mode."""
        return self._derived[0]

    @property
    def local(self) -> Vectors:
        """Derivatives by what the block alone has: parts of each mode's unknown state, then the drive's error."""
        return self._derived[1]


def stack(values: Lines) -> Real:
    """Complex (..., lines) to real (2 lines, ...), the same least-squares problem in real numbers.

    Each line's real part stands above its imaginary part, as they lie in memory: hundreds of FRFs are not copied.
    """
    lies = values.dtype == np.complex128 and values.strides[-1] == values.itemsize
    return np.moveaxis((values if lies else np.ascontiguousarray(values, np.complex128)).view(np.float64), -1, 0)


def unstack(rows: Real) -> Lines:
    """Real (2 lines, ...) back to complex (..., lines)."""
    return np.ascontiguousarray(np.moveaxis(rows, 0, -1)).view(np.complex128)


def poles_of(omega: Real, zeta: Real) -> NDArray[np.complex128]:
    """Poles lambda = -zeta omega + j omega sqrt(1 - zeta^2), in rad/s."""
    return -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)


@dataclass(frozen=True, eq=False, slots=True)
class _Half:
    """What belongs to one of a pole pair, each (modes, lines)."""

    forced: Lines
    slope: Lines
    free: Lines
    free_slope: Lines


class Shared:
    """What all blocks of one grid have in common at given poles: kernels, and free decays from the same sample."""

    def __init__(self, grid: Grid, poles: NDArray[np.complex128]) -> None:
        self._pair = poles, poles.conj()
        self._grid = grid
        self._kernels: tuple[Kernel, ...] = ()
        self._free: dict[int, tuple[tuple[Lines, Lines], ...]] = {}
        self._vectors: dict[int, Vectors] = {}

    def halves(self, excitation: Excitation, *, free: bool) -> tuple[_Half, _Half]:
        """Both of every pole pair in a block that this drove."""
        if isinstance(excitation, BlowExcitation):
            self._kernels = self._kernels or tuple(kernel(self._grid, p) for p in self._pair)
        kernels: tuple[Kernel | None, ...] = self._kernels or (None, None)
        forced = [excitation.forced(p, k) for p, k in zip(self._pair, kernels, strict=True)]
        if not free:
            nothing = np.zeros((1, 1), complex)
            return _Half(*forced[0], nothing, nothing), _Half(*forced[1], nothing, nothing)
        decays = self._free.get(excitation.state_at)
        if decays is None:
            decays = self._free[excitation.state_at] = tuple(excitation.free(p) for p in self._pair)
        return _Half(*forced[0], *decays[0]), _Half(*forced[1], *decays[1])

    def state_vectors(self, excitation: Excitation, up: _Half, down: _Half) -> Vectors:
        """Derivatives by the unknown states."""
        place = excitation.state_at
        if place not in self._vectors:
            self._vectors[place] = _state_vectors(up.free, down.free)
        return self._vectors[place]


def columns(
    excitation: Excitation,
    omega: Real,
    zeta: Real,
    state: NDArray[np.complex128] | None,
    drive: complex | None,
    powers: Sequence[int],
    shared: Shared | None = None,
) -> BlockColumns:
    """Columns of a block and their derivatives.

    Args:
        excitation: what drove the block.
        omega: (modes,) undamped natural frequencies, rad/s.
        zeta: (modes,) damping ratios.
        state: (modes,) unknown modal states, or None for a block that has none.
        drive: unknown relative error of the drive's complex amplitude, or None.
        powers: powers of s of the receptance's residual terms.
        shared: what blocks of one grid have in common at these poles, where several are wanted.
    """
    poles = poles_of(omega, zeta)
    common = shared or Shared(excitation.grid, poles)
    true_drive = excitation if drive is None else excitation.scaled(1 + drive)
    up, down = common.halves(true_drive, free=state is not None)
    start = np.zeros(len(omega), complex) if state is None else state
    value = _pair(up.forced + start[:, None] * up.free, down.forced + start.conj()[:, None] * down.free)
    phi = np.concatenate([value.reshape(-1, value.shape[-1]), _statics(true_drive, powers)])

    def derive() -> tuple[Vectors, Vectors]:
        local = [] if state is None else [common.state_vectors(excitation, up, down)]
        if drive is not None:
            local.append(_drive_vectors(excitation, poles, powers, first=0 if state is None else 2 * len(omega)))
        return _pole_vectors(omega, zeta, (up, down), start), _joined(local)

    return BlockColumns(stack(phi), derive)


def _pole_vectors(omega: Real, zeta: Real, halves: tuple[_Half, _Half], start: NDArray[np.complex128]) -> Vectors:
    up, down = halves
    slope_up = up.slope + start[:, None] * up.free_slope
    slope_down = down.slope + start.conj()[:, None] * down.free_slope
    rates = (poles_of(omega, zeta) / omega, -omega - 1j * omega * zeta / np.sqrt(1 - zeta**2))
    values = np.stack([_pair(slope_up * r[:, None], slope_down * r.conj()[:, None]) for r in rates], axis=1)
    mode = np.repeat(np.arange(len(omega)), 4)
    which = np.tile([0, 0, 1, 1], len(omega))
    part = np.tile([0, 1, 0, 1], len(omega))
    return Vectors(stack(values.reshape(-1, values.shape[-1])), 2 * mode + which, 2 * mode + part)


def _pair(up: Lines, down: Lines) -> Lines:
    """(modes, 2, lines): what the real and the imaginary part of the residue multiply, R up + conj(R) down."""
    return np.stack([up + down, 1j * (up - down)], axis=1)


def _statics(excitation: Excitation, powers: Sequence[int]) -> Lines:
    if not powers:
        return np.zeros((0, excitation.static(0).size), complex)
    return np.stack([excitation.static(power) for power in powers])


def _state_vectors(up: Lines, down: Lines) -> Vectors:
    u, v = np.moveaxis(_pair(up, down), 1, 0)
    n_modes = len(up)
    values = np.stack([u, v, v, -u], axis=1).reshape(4 * n_modes, -1)
    mode = np.repeat(np.arange(n_modes), 4)
    return Vectors(stack(values), 2 * mode + np.tile([0, 0, 1, 1], n_modes), 2 * mode + np.tile([0, 1, 0, 1], n_modes))


def _drive_vectors(
    excitation: Excitation, poles: NDArray[np.complex128], powers: Sequence[int], *, first: int
) -> Vectors:
    found: list[Lines] = []
    for turned in (excitation, excitation.scaled(1j)):
        pairs = _pair(turned.forced(poles)[0], turned.forced(poles.conj())[0])
        found.append(np.concatenate([pairs.reshape(-1, pairs.shape[-1]), _statics(turned, powers)]))
    n = len(found[0])
    return Vectors(stack(np.concatenate(found)), first + np.repeat([0, 1], n), np.tile(np.arange(n), 2))


def _joined(parts: Sequence[Vectors]) -> Vectors:
    if len(parts) == 1:
        return parts[0]
    if not parts:
        return Vectors(np.zeros((0, 0)), np.zeros(0, np.int64), np.zeros(0, np.int64))
    return Vectors(
        np.concatenate([p.values for p in parts], axis=1),
        np.concatenate([p.parameter for p in parts]),
        np.concatenate([p.column for p in parts]),
    )
