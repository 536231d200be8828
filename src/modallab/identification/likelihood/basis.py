"""Columns of the modal model in a block, for given poles."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.likelihood.derivatives import (
    DerivativeVectors,
    HalfOfPair,
    columns_of_residue,
    drive_vectors,
    join_vectors,
    pole_vectors,
    poles_of,
    residual_term_columns,
    state_vectors,
)
from modallab.identification.likelihood.excitation import (
    BlockLines,
    Excitation,
    HitExcitation,
    Lines,
    PoleKernel,
    kernel_of_poles,
)
from modallab.identification.likelihood.orthonormal import real_rows


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
