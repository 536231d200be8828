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
        start: where an unknown state may enter: 0 for a beam that was not at rest.
        first: first sample of the blow.
    """

    grid: Grid
    force: NDArray[np.float64]
    start: int
    first: int = 0

    def _spectrum(self) -> Lines:
        index = np.round(self.grid.omega * self.grid.dt * self.grid.n / (2 * np.pi)).astype(int)
        return np.fft.rfft(self.force)[index]

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        g = self.grid
        lam, s = poles[:, None], 1j * g.omega
        where = np.flatnonzero(self.force)
        # G z^N in one, sum_m f_m z^(N - m): apart, the one may overflow while the other vanishes.
        left = (g.n - where) * g.dt
        decay = np.exp(np.outer(poles, left)) * self.force[where]
        tail, by_pole = decay.sum(axis=1)[:, None], (decay @ left)[:, None]
        zw = np.exp((lam - s) * g.dt)
        scale = lam**g.p * g.dt / (1 - zw)
        steady = s**g.p * self._spectrum() / (s - lam)
        value = steady - scale * tail
        slope = steady / (s - lam) - scale * (tail * (g.p / lam + g.dt * zw / (1 - zw)) + by_pole)
        return value, slope

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return _free(self.grid, poles, self.start)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        return (1j * self.grid.omega) ** (self.grid.p + power) * self._spectrum()

    def corrected(self, change: NDArray[np.float64]) -> "BlowExcitation":
        """The same with `change` (width,) in N added from the blow's first sample on."""
        force = self.force.copy()
        force[self.first : self.first + change.size] += change
        return replace(self, force=force)

    def scaled(self, factor: complex) -> "BlowExcitation":
        """See Excitation; a blow has no phase to turn, its real part counts."""
        return replace(self, force=self.force * factor.real)


@dataclass(frozen=True, eq=False, slots=True)
class ToneExcitation:
    """A sine over the whole block, and the decay of what came before it.

    The unknown state is the mode's whole state at the block's start, forced and free together: near a resonance both
    grow without bound as the pole moves, and only their sum is known well. Its forced response therefore begins at
    zero state. For modes that have died out it is the steady state instead.

    Attributes:
        grid: the block's lines.
        frequency_hz: of the sine, which need not stand on a line.
        amplitude: complex peak force in N: f(t) = Re(amplitude exp(j omega t)), t from the block's start.
        settled_from: rad/s; modes above respond with their steady state.
        shapes: (2, lines) spectra of exp(j omega t) / 2 and exp(-j omega t) / 2; see `tone`.
    """

    grid: Grid
    frequency_hz: float
    amplitude: complex
    settled_from: float
    shapes: Lines

    def _tones(self) -> tuple[tuple[complex, Lines], tuple[complex, Lines]]:
        """(s, spectrum) of the sine's positive and negative frequency."""
        s = 2j * np.pi * self.frequency_hz
        return (s, self.amplitude * self.shapes[0]), (-s, np.conj(self.amplitude) * self.shapes[1])

    def forced(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        (s, up), (minus_s, down) = self._tones()
        lam, p = poles[:, None], self.grid.p
        first, second = 1 / (s - lam), 1 / (minus_s - lam)
        value = s**p * first * up + minus_s**p * second * down
        slope = s**p * first**2 * up + minus_s**p * second**2 * down
        free, free_slope = self.free(poles)
        state, state_slope = (x[:, None] for x in self.steady_state(poles))
        return value - state * free, slope - state_slope * free - state * free_slope

    def steady_state(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """State (modes,) of the steady response at the block's start, and its derivative by the pole."""
        s = 2j * np.pi * self.frequency_hz
        first, second = 1 / (s - poles), 1 / (-s - poles)
        rings = np.abs(poles.imag) < self.settled_from
        half = self.amplitude / 2
        other = np.conj(half)
        return rings * (half * first + other * second), rings * (half * first**2 + other * second**2)

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return _free(self.grid, poles, 0)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        (s, up), (minus_s, down) = self._tones()
        p = self.grid.p + power
        return s**p * up + minus_s**p * down

    def scaled(self, factor: complex) -> "ToneExcitation":
        """See Excitation."""
        return replace(self, amplitude=self.amplitude * factor)


def tone(grid: Grid, frequency_hz: float, amplitude: complex, settled_from: float) -> ToneExcitation:
    """A steady sine in a block; see ToneExcitation."""
    s = 2j * np.pi * frequency_hz
    shapes = np.stack([_geometric(s, grid), _geometric(-s, grid)]) / 2
    return ToneExcitation(grid, frequency_hz, amplitude, settled_from, shapes)


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
        return np.power(1j * self.grid.omega, self.grid.p + power, dtype=np.complex128)

    def scaled(self, factor: complex) -> "UnitExcitation":
        """See Excitation; an FRF is already per unit force."""
        del factor
        return self
