"""Columns of the modal model in a block, for given poles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.derivatives import (
    Half,
    Vectors,
    drive_vectors,
    joined,
    pair,
    pole_vectors,
    state_vectors,
    statics,
)
from modallab.identification.likelihood.excitation import Excitation, Grid, HitExcitation, Kernel, Lines, kernel
from modallab.identification.likelihood.poles import poles_of
from modallab.identification.likelihood.rows import stack


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


class Shared:
    """What all blocks of one grid have in common at given poles: kernels, and free decays from the same sample."""

    def __init__(self, grid: Grid, poles: NDArray[np.complex128]) -> None:
        self._pair = poles, poles.conj()
        self._grid = grid
        self._kernels: tuple[Kernel, ...] = ()
        self._free: dict[int, tuple[tuple[Lines, Lines], ...]] = {}
        self._vectors: dict[int, Vectors] = {}

    def halves(self, excitation: Excitation, *, free: bool) -> tuple[Half, Half]:
        """Both of every pole pair in a block that this drove."""
        if isinstance(excitation, HitExcitation):
            self._kernels = self._kernels or tuple(kernel(self._grid, p) for p in self._pair)
        kernels: tuple[Kernel | None, ...] = self._kernels or (None, None)
        forced = [excitation.forced(p, k) for p, k in zip(self._pair, kernels, strict=True)]
        if not free:
            nothing = np.zeros((1, 1), complex)
            return Half(*forced[0], nothing, nothing), Half(*forced[1], nothing, nothing)
        decays = self._free.get(excitation.state_at)
        if decays is None:
            decays = self._free[excitation.state_at] = tuple(excitation.free(p) for p in self._pair)
        return Half(*forced[0], *decays[0]), Half(*forced[1], *decays[1])

    def state_vectors(self, excitation: Excitation, up: Half, down: Half) -> Vectors:
        """Derivatives by the unknown states."""
        place = excitation.state_at
        if place not in self._vectors:
            self._vectors[place] = state_vectors(up.free, down.free)
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
        shared: what blocks of one grid have in common at these poles, where several are requested.
    """
    poles = poles_of(omega, zeta)
    common = shared or Shared(excitation.grid, poles)
    true_drive = excitation if drive is None else excitation.scaled(1 + drive)
    up, down = common.halves(true_drive, free=state is not None)
    start = np.zeros(len(omega), complex) if state is None else state
    value = pair(up.forced + start[:, None] * up.free, down.forced + start.conj()[:, None] * down.free)
    phi = np.concatenate([value.reshape(-1, value.shape[-1]), statics(true_drive, powers)])

    def derive() -> tuple[Vectors, Vectors]:
        local = [] if state is None else [common.state_vectors(excitation, up, down)]
        if drive is not None:
            local.append(drive_vectors(excitation, poles, powers, first=0 if state is None else 2 * len(omega)))
        return pole_vectors(omega, zeta, (up, down), start), joined(local)

    return BlockColumns(stack(phi), derive)
