"""A steady sine in a block, and the decay of what came before it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.identification.likelihood.excitation import BlockLines, Lines, PoleKernel, free_decay


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
        settled: so many of the last poles respond with their steady state, wherever they stand: those that stand for
            modes above the band, which have died out before a block begins.
        shapes: (2, lines) spectra of exp(j omega t) / 2 and exp(-j omega t) / 2; see `tone_excitation`.
    """

    grid: BlockLines
    frequency_hz: float
    amplitude: complex
    settled: int
    shapes: Lines

    def _tones(self) -> tuple[tuple[complex, Lines], tuple[complex, Lines]]:
        """(s, spectrum) of the sine's positive and negative frequency."""
        s = 2j * np.pi * self.frequency_hz
        return (s, self.amplitude * self.shapes[0]), (-s, np.conj(self.amplitude) * self.shapes[1])

    def forced(self, poles: NDArray[np.complex128], shared: PoleKernel | None = None) -> tuple[Lines, Lines]:
        """See Excitation."""
        del shared
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
        rings = np.arange(poles.size) < poles.size - self.settled
        half = self.amplitude / 2
        other = np.conj(half)
        return rings * (half * first + other * second), rings * (half * first**2 + other * second**2)

    @property
    def state_at(self) -> int:
        """See Excitation."""
        return 0

    def free(self, poles: NDArray[np.complex128]) -> tuple[Lines, Lines]:
        """See Excitation."""
        return free_decay(self.grid, poles, 0)

    def static(self, power: int) -> Lines:
        """See Excitation."""
        (s, up), (minus_s, down) = self._tones()
        p = self.grid.p + power
        return s**p * up + minus_s**p * down

    def scaled(self, factor: complex) -> "ToneExcitation":
        """See Excitation."""
        return replace(self, amplitude=self.amplitude * factor)


def tone_excitation(grid: BlockLines, frequency_hz: float, amplitude: complex, settled: int) -> ToneExcitation:
    """A steady sine in a block; see ToneExcitation."""
    s = 2j * np.pi * frequency_hz
    shapes = np.stack([_geometric(s, grid), _geometric(-s, grid)]) / 2
    return ToneExcitation(grid, frequency_hz, amplitude, settled, shapes)


def _geometric(s: complex, grid: BlockLines) -> Lines:
    """DFT of exp(s n dt), n = 0..N-1, at the grid's lines; N where the exponential stands on the line."""
    ratio = np.exp(s * grid.dt - 1j * grid.omega * grid.dt)
    on_line = np.abs(1 - ratio) < 1e-9
    value = np.where(on_line, grid.n, (1 - np.exp(s * grid.dt * grid.n)) / np.where(on_line, 1, 1 - ratio))
    return value.astype(np.complex128)
