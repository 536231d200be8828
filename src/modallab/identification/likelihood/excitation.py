"""The response of one pole in one block, at the block's DFT lines, with the block's truncation in it.

A block is shorter than the ring-down of a lightly damped mode, so its spectrum is not FRF times force. For a system
at rest at the block's start the difference is known exactly: what a periodic repetition would have carried over
from the block's end is taken off in closed form. With F the force spectrum and p the times the output differentiates
the displacement, the pole lambda answers

    P(lambda) = s^p F / (s - lambda) - lambda^p dt G(lambda) z^N / (1 - z w),
    G(lambda) = sum_m f_m z^-m,   z = exp(lambda dt),   w = exp(-j omega dt),

and a free decay that begins at sample n0 with unit modal state

    Z(lambda) = lambda^p (w^n0 - z^(N - n0)) / (1 - z w)         (w^N = 1 at DFT lines).

Source: the geometric sum of sampled exponentials; compare Pintelon and Schoukens, "System Identification: A Frequency
Domain Approach", 2nd ed. (2012), section 2.6, on the transient term of the DFT.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Lines = NDArray[np.complex128]


@dataclass(frozen=True, eq=False, slots=True)
class BlockLines:
    """DFT lines of a block: omega (lines,) rad/s, n samples dt apart, p the output's derivative order."""

    omega: NDArray[np.float64]
    n: int
    dt: float
    p: int


@dataclass(frozen=True, eq=False, slots=True)
class PoleKernel:
    """What poles do at a grid's lines whatever drives them, (modes, lines): shared by all blocks of one grid.

    Attributes:
        poles: (modes,)
        resonance: 1 / (s - lambda).
        wrap: 1 / (1 - z w).
        turned: z w / (1 - z w).
    """

    poles: NDArray[np.complex128]
    resonance: Lines
    wrap: Lines
    turned: Lines


def kernel_of_poles(grid: BlockLines, poles: NDArray[np.complex128]) -> PoleKernel:
    """See Kernel."""
    away = 1j * grid.omega - poles[:, None]
    zw = np.exp(-away * grid.dt, dtype=np.complex128)
    wrap: Lines = np.reciprocal(1 - zw)
    return PoleKernel(poles, 1 / away, wrap, zw * wrap)


class Excitation(Protocol):
    """What drove a block; answers for poles (modes,), each result and its derivative by the pole (modes, lines)."""

    @property
    def grid(self) -> BlockLines:
        """The block's lines."""
        ...

    def forced(self, poles: NDArray[np.complex128], shared: PoleKernel | None = None) -> tuple[Lines, Lines]:
        """Response to the force from rest, of receptance 1 / (s - lambda). `shared` is these poles' on this grid."""
        ...

    @property
    def state_at(self) -> int:
        """Sample at which an unknown state may enter: blocks of one grid with the same have the same free decays."""
        ...

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """Free decay of unit modal state from that sample on."""
        ...

    def static(self, power: int) -> Lines:
        """Response (lines,) of receptance s^power: what modes outside the band leave."""
        ...

    def scaled(self, factor: complex) -> "Excitation":
        """The same with the force's complex amplitude times a factor."""
        ...


def free_decay(grid: BlockLines, poles: NDArray[np.complex128], start: int) -> tuple[Lines, Lines]:
    """Z of the poles and its derivative, (modes, lines), from sample `start` on."""
    lam = poles[:, None]
    z = np.exp(lam * grid.dt)
    w = np.exp(-1j * grid.omega * grid.dt)
    left = grid.n - start
    top = w**start - z**left
    bottom = 1 - z * w
    value = lam**grid.p * top / bottom
    slope = grid.p * value / lam + lam**grid.p * grid.dt * (-left * z**left / bottom + top * z * w / bottom**2)
    return value, slope


@dataclass(frozen=True, eq=False, slots=True)
class HitExcitation:
    """A hit inside the block, zero elsewhere. An unknown state may enter at sample `start`.

    Attributes:
        grid: the block's lines.
        force: (n,) N, zero outside the hit.
        start: where an unknown state may enter: 0 for a beam that was not at rest.
        first: first sample of the hit.
    """

    grid: BlockLines
    force: NDArray[np.float64]
    start: int
    first: int = 0

    def _spectrum(self) -> Lines:
        index = np.round(self.grid.omega * self.grid.dt * self.grid.n / (2 * np.pi)).astype(int)
        return np.fft.rfft(self.force)[index]

    def forced(self, poles: NDArray[np.complex128], shared: PoleKernel | None = None) -> tuple[Lines, Lines]:
        """See Excitation."""
        g, of = self.grid, shared or kernel_of_poles(self.grid, poles)
        lam = poles[:, None]
        where = np.flatnonzero(self.force)
        # G z^N in one, sum_m f_m z^(N - m): apart, the one may overflow while the other vanishes.
        left = (g.n - where) * g.dt
        decay = np.exp(np.outer(poles, left)) * self.force[where]
        scale = lam**g.p * g.dt
        tail, by_pole = scale * decay.sum(axis=1)[:, None], scale * (decay @ left)[:, None]
        steady = ((1j * g.omega) ** g.p * self._spectrum()) * of.resonance
        value = steady - tail * of.wrap
        slope = steady * of.resonance - of.wrap * (tail * g.dt * of.turned + (tail * g.p / lam + by_pole))
        return value, slope

    @property
    def state_at(self) -> int:
        """See Excitation."""
        return self.start

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return free_decay(self.grid, poles, self.start)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return (1j * self.grid.omega) ** (self.grid.p + power) * self._spectrum()

    def corrected(self, change: NDArray[np.float64]) -> "HitExcitation":
        """The same with `change` (width,) in N added from the hit's first sample on."""
        force = self.force.copy()
        force[self.first : self.first + change.size] += change
        return replace(self, force=force)

    def scaled(self, factor: complex) -> "HitExcitation":
        """See Excitation; a hit has no phase to turn, its real part counts."""
        return replace(self, force=self.force * factor.real)


@dataclass(frozen=True, eq=False, slots=True)
class UnitExcitation:
    """An FRF as such: unit force at every line and no block.

    Attributes:
        grid: the lines.
        shift: rate in 1/s: the FRF is evaluated at s = shift + j omega, as an exponential window leaves it.
        weight: (lines,) by which responses are multiplied; None for 1.
    """

    grid: BlockLines
    shift: float = 0.0
    weight: NDArray[np.float64] | None = None

    @property
    def _s(self) -> Lines:
        return np.asarray(self.shift + 1j * self.grid.omega, np.complex128)

    def _weighted(self, values: Lines) -> Lines:
        return values if self.weight is None else values * self.weight

    def forced(self, poles: NDArray[np.complex128], shared: PoleKernel | None = None) -> tuple[Lines, Lines]:
        """See Excitation."""
        del shared
        s, lam = self._s, poles[:, None]
        value = self._weighted(s**self.grid.p / (s - lam))
        return value, value / (s - lam)

    @property
    def state_at(self) -> int:
        """See Excitation."""
        return 0

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """An FRF has no state to begin with: zero."""
        nothing = np.zeros((poles.size, self.grid.omega.size), complex)
        return nothing, nothing

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return self._weighted(np.power(self._s, self.grid.p + power, dtype=np.complex128))

    def scaled(self, factor: complex) -> "UnitExcitation":
        """See Excitation; an FRF is already per unit force."""
        del factor
        return self


@dataclass(frozen=True, eq=False, slots=True)
class RandomExcitation:
    """A record's force by its spectrum at the lines; what rings at its ends is a free state."""

    grid: BlockLines
    force: Lines

    def forced(self, poles: NDArray[np.complex128], shared: PoleKernel | None = None) -> tuple[Lines, Lines]:
        """See Excitation."""
        del shared
        s, lam = 1j * self.grid.omega, poles[:, None]
        value = s**self.grid.p * self.force / (s - lam)
        return value, value / (s - lam)

    @property
    def state_at(self) -> int:
        """See Excitation."""
        return 0

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return free_decay(self.grid, poles, 0)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return np.power(1j * self.grid.omega, self.grid.p + power, dtype=np.complex128) * self.force

    def scaled(self, factor: complex) -> "RandomExcitation":
        """See Excitation."""
        return replace(self, force=self.force * factor)
