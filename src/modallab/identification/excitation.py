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
class Grid:
    """DFT lines of a block: omega (lines,) rad/s, n samples dt apart, p the output's derivative order."""

    omega: NDArray[np.float64]
    n: int
    dt: float
    p: int


class Excitation(Protocol):
    """What drove a block; answers for poles (modes,), each result and its derivative by the pole (modes, lines)."""

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """Response to the force from rest, of receptance 1 / (s - lambda)."""
        ...

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """Free decay of unit modal state from the sample where an unknown state may enter."""
        ...

    def static(self, power: int) -> Lines:
        """Response (lines,) of receptance s^power: what modes outside the band leave."""
        ...

    def scaled(self, factor: complex) -> "Excitation":
        """The same with the force's complex amplitude times a factor."""
        ...


def _free(grid: Grid, poles: NDArray[np.complex128], start: int) -> tuple[Lines, Lines]:
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
class BlowExcitation:
    """A blow inside the block, zero elsewhere. An unknown state may enter at sample `start`.

    Attributes:
        grid: the block's lines.
        force: (n,) N, zero outside the blow.
        start: 0 for a beam that was not at rest; the blow's own sample for what the force's noise did.
    """

    grid: Grid
    force: NDArray[np.float64]
    start: int

    def _spectrum(self) -> Lines:
        index = np.round(self.grid.omega * self.grid.dt * self.grid.n / (2 * np.pi)).astype(int)
        return np.fft.rfft(self.force)[index]

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        g = self.grid
        lam, s = poles[:, None], 1j * g.omega
        where = np.flatnonzero(self.force)
        decay = np.exp(-np.outer(poles * g.dt, where)) * self.force[where]
        g0 = decay.sum(axis=1)[:, None]
        g1 = -g.dt * (decay @ where)[:, None]
        z = np.exp(lam * g.dt)
        w = np.exp(-1j * g.omega * g.dt)
        end, bottom = z**g.n, 1 - z * w
        scale = lam**g.p * g.dt * end / bottom
        steady = s**g.p * self._spectrum() / (s - lam)
        value = steady - scale * g0
        slope = steady / (s - lam) - scale * (g0 * (g.p / lam + g.n * g.dt + g.dt * z * w / bottom) + g1)
        return value, slope

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return _free(self.grid, poles, self.start)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return (1j * self.grid.omega) ** (self.grid.p + power) * self._spectrum()

    def scaled(self, factor: complex) -> "BlowExcitation":
        """See Excitation; a blow has no phase to turn, its real part counts."""
        return replace(self, force=self.force * factor.real)


@dataclass(frozen=True, eq=False, slots=True)
class ToneExcitation:
    """A steady sine over the whole block, and the decay of what came before it.

    Attributes:
        grid: the block's lines.
        frequency_hz: of the sine, which need not stand on a line.
        amplitude: complex peak force in N: f(t) = Re(amplitude exp(j omega t)), t from the block's start.
    """

    grid: Grid
    frequency_hz: float
    amplitude: complex

    def _tones(self) -> list[tuple[complex, Lines]]:
        """(s, spectrum of amplitude exp(s t) / 2) for the sine's positive and negative frequency."""
        g = self.grid
        tones: list[tuple[complex, Lines]] = []
        for sign in (1, -1):
            s = sign * 2j * np.pi * self.frequency_hz
            half = (self.amplitude if sign > 0 else np.conj(self.amplitude)) / 2
            tones.append((s, half * _geometric(s, g)))
        return tones

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation; the steady state only."""
        lam = poles[:, None]
        value = sum((s**self.grid.p / (s - lam) * tone for s, tone in self._tones()), np.zeros(1, complex))
        slope = sum((s**self.grid.p / (s - lam) ** 2 * tone for s, tone in self._tones()), np.zeros(1, complex))
        return value, slope

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return _free(self.grid, poles, 0)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return np.asarray(sum(s ** (self.grid.p + power) * tone for s, tone in self._tones()), dtype=np.complex128)

    def scaled(self, factor: complex) -> "ToneExcitation":
        """See Excitation."""
        return replace(self, amplitude=self.amplitude * factor)


def _geometric(s: complex, grid: Grid) -> Lines:
    """DFT of exp(s n dt), n = 0..N-1, at the grid's lines; N where the exponential stands on the line."""
    ratio = np.exp(s * grid.dt - 1j * grid.omega * grid.dt)
    on_line = np.abs(1 - ratio) < 1e-9
    value = np.where(on_line, grid.n, (1 - np.exp(s * grid.dt * grid.n)) / np.where(on_line, 1, 1 - ratio))
    return value.astype(np.complex128)


@dataclass(frozen=True, eq=False, slots=True)
class UnitExcitation:
    """An FRF as such: unit force at every line and no block."""

    grid: Grid

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        s, lam = 1j * self.grid.omega, poles[:, None]
        value = s**self.grid.p / (s - lam)
        return value, value / (s - lam)

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """An FRF has no state to begin with: zero."""
        nothing = np.zeros((poles.size, self.grid.omega.size), complex)
        return nothing, nothing

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return (1j * self.grid.omega) ** (self.grid.p + power)

    def scaled(self, factor: complex) -> "UnitExcitation":
        """See Excitation; an FRF is already per unit force."""
        del factor
        return self
