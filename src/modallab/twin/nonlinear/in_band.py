"""What was stepped finer than a record is sampled, as a converter samples it: without what rings above its band."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

REACH = 12
"""Samples to either side of the filter that keeps what rings above the band from folding back into it."""


@dataclass(frozen=True, eq=False, slots=True)
class Fine:
    """What an element adds to a record, before the chain, step by step.

    Attributes:
        modes: (2 kept, steps) motion of the first modes, real parts and then imaginary ones; those beyond follow the
            force at once.
        force: (m, steps) of the element's channels, N.
        every: steps a sample.
        before: steps before the first sample; where these are fewer than the filter reaches, all was at rest before.
        n: samples of the record.
        still: samples at its begin, before these steps, at which all is at rest.
    """

    modes: Array
    force: Array
    every: int
    before: int
    n: int
    still: int = 0

    def sampled(self) -> tuple[Complex, Array]:
        """(kept, n) complex motion of the first modes and (n, m) force, at the samples."""
        motion, force = self._samples(self.modes), self._samples(self.force)
        kept = len(motion) // 2
        # Motion that grew without bound stays infinite: no product with 1j may make it undefined.
        modes = motion[:kept].astype(complex)
        modes.imag = motion[kept:]
        return modes, np.ascontiguousarray(force.T)

    def on_lines(self, lines: Array) -> tuple[Complex, Complex]:
        """(2 kept, lines) and (m, lines) DFT of the record's samples, on lines that may be below zero."""
        if len(lines) > self.n // 16 or self.still:
            at = np.abs(lines).astype(int)
            whole = [np.fft.rfft(self._samples(rows))[:, at] for rows in (self.modes, self.force)]
            motion, force = (np.where(lines < 0, rows.conj(), rows) for rows in whole)
            return motion, force
        weights = _weights(self.every, self.before, self.modes.shape[1], self.n, lines.tobytes())
        motion, force = (rows @ weights for rows in (self.modes, self.force))
        half = len(lines)
        return motion[:, :half] + 1j * motion[:, half:], force[:, :half] + 1j * force[:, half:]

    def _samples(self, fine: Array) -> Array:
        n = self.n - self.still
        found = np.zeros((len(fine), self.n))
        found[:, self.still :] = _thinned(fine, self.every, self.before, n)
        return found


def _thinned(fine: Array, every: int, before: int, n: int) -> Array:
    """(rows, n) of (rows, steps) every so many steps, `before` steps on, without what would fold back."""
    if every == 1:
        return fine[:, before : before + n]
    from modallab.twin.nonlinear.sampling import decimate

    first, needed = REACH * every - before, (n - 1 + 2 * REACH) * every + 1
    some = min(fine.shape[1], needed - first)
    padded = np.zeros((len(fine), needed))
    padded[:, first : first + some] = fine[:, :some]
    found = np.empty((len(fine), n))
    decimate(padded, _taps(every), every, found)
    return found


@lru_cache(maxsize=16)
def _taps(every: int) -> Array:
    return np.asarray(firwin(2 * REACH * every + 1, 1 / every, window=("kaiser", 8.0)), dtype=np.float64)


# Up to 2 MB each: as many as a campaign's sines need, in fine steps and in coarse ones.
@lru_cache(maxsize=160)
def _weights(every: int, before: int, steps: int, n: int, lines: bytes) -> Array:
    """(steps, 2 lines) by which steps add up to the DFT of their samples: real parts, then imaginary ones."""
    turns = np.exp(-2j * np.pi / n * np.outer(np.frombuffer(lines), np.arange(n)))
    spread = np.zeros((len(turns), (n - 1) * every + 1), dtype=np.complex128)
    spread[:, ::every] = turns
    if every > 1:
        spread = np.stack([np.convolve(row, _taps(every)) for row in spread])
    first = before - (REACH * every if every > 1 else 0)
    found = np.zeros((steps, len(turns)), dtype=np.complex128)
    some = min(steps - max(first, 0), spread.shape[1] + min(first, 0))
    found[max(first, 0) :][:some] = spread.T[max(-first, 0) :][:some]
    return np.concatenate([found.real, found.imag], axis=1)
