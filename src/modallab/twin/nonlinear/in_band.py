"""What was stepped finer than a record is sampled, as a converter samples it: without what rings above its band."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.nonlinear.steps import ElementForces

REACH = 12
"""Samples to either side of the filter that keeps what rings above the band from folding back into it."""


@dataclass(frozen=True, eq=False, slots=True)
class FineSteps:
    """What an element adds to a record, before the chain, step by step.

    Attributes:
        pushed: its forces and the modes; modes that are not kept follow the force at once.
        every: steps a sample.
        before: steps before the first sample; where these are fewer than the filter reaches, all was at rest before.
        n: samples of the record.
        still: samples at its begin, before these steps, at which all is at rest.
    """

    pushed: ElementForces
    every: int
    before: int
    n: int
    still: int = 0

    def sampled(self) -> tuple[Complex, Real]:
        """(kept, n) complex motion of the first modes and (n, m) force, at the samples."""
        force = self.pushed.forces[: self.pushed.channels]
        motion, force = self._samples(self.pushed.motion()), self._samples(force)
        kept = len(motion) // 2
        # Motion that grew without bound stays infinite: no product with 1j may make it undefined.
        modes = motion[:kept].astype(complex)
        modes.imag = motion[kept:]
        return modes, np.ascontiguousarray(force.T)

    def on_lines(self, lines: Real) -> tuple[Complex, Complex]:
        """(2 kept, lines) and (m, lines) DFT of the record's samples, on lines that may be below zero.

        Not a number where the motion grows without bound. The filter is linear: what it leaves of the modes is what
        the forces make of them that it leaves. The sum of all samples follows from the first state and the last, as
        that of a geometric series does.
        """
        p, n = self.pushed, self.n - self.still
        if not np.all(np.isfinite(p.forces)):
            # Motion that grew without bound has no lines.
            nothing = np.full((2 * len(p.decay) + p.channels, len(lines)), np.nan, dtype=complex)
            return nothing[p.channels :], nothing[: p.channels]
        forces = self._in_band()
        turn: Complex = np.exp(-2j * np.pi / self.n * lines)
        phases = _dft_of_phases(forces[:, :-1].reshape(len(forces), n - 1, self.every), lines, self.n)
        whole = phases[:, 0] + forces[:, -1:] * turn ** (n - 1)
        step, driven = self._step()
        first = self._first_state(forces[:, 0])
        last = step ** (n - 1) * first + np.sum(p.acts * p.left(forces[:, :-1]), axis=0)
        driving = phases.reshape(-1, len(lines))
        ends = (first, last, step)
        own = _summed_states(turn, n, ends, driven.T @ driving) + p.at_once.T @ whole
        mirrored = (
            _summed_states(turn, n, tuple(map(np.conj, ends)), driven.conj().T @ driving) + p.at_once.conj().T @ whole
        )
        later = turn**self.still
        motion = np.concatenate([(own + mirrored) / 2, (own - mirrored) / 2j])
        return motion * later, whole[: p.channels] * later

    def _step(self) -> tuple[Complex, Complex]:
        """(kept,) what a sample leaves of the state, and (f every, kept) what each force of its steps adds to it."""
        p = self.pushed
        left = p.decay ** np.arange(self.every)[::-1, None]
        return p.decay**self.every, (p.acts[:, None] * left).reshape(-1, len(p.decay))

    def _in_band(self) -> Real:
        """(f, (n - 1) every + 1) the forces at each step from the first sample to the last, filtered."""
        from modallab.twin.nonlinear.sampling import filter_rows

        count = (self.n - self.still - 1) * self.every + 1
        out = np.empty((len(self.pushed.forces), count))
        filter_rows(self._about_samples(self.pushed.forces), _filter_taps(self.every), out)
        return out

    def _first_state(self, force: Real) -> Complex:
        """(kept,) filtered state of the modes at the first sample, where the filtered forces are `force` (f,)."""
        reach = _filter_reach(self.every)
        motion = self.pushed.motion(self.before + reach + 1)[:, max(self.before - reach, 0) :]
        found, kept = motion @ _filter_taps(self.every)[-motion.shape[1] :], len(motion) // 2
        return found[:kept] + 1j * found[kept:] - force @ self.pushed.at_once

    def _samples(self, fine: Real) -> Real:
        """(rows, n) of (rows, steps), without what would fold back."""
        from modallab.twin.nonlinear.sampling import decimate_rows

        found = np.zeros((len(fine), self.n))
        own = np.empty((len(fine), self.n - self.still))
        decimate_rows(self._about_samples(fine), _filter_taps(self.every), self.every, own)
        found[:, self.still :] = own
        return found

    def _about_samples(self, fine: Real) -> Real:
        """(rows, ...) the steps that the filter reaches from the first sample and from the last, zeros before."""
        reach, n = _filter_reach(self.every), self.n - self.still
        first, needed = reach - self.before, (n - 1) * self.every + 2 * reach + 1
        if first <= 0:
            return np.ascontiguousarray(fine[:, -first : needed - first])
        found = np.zeros((len(fine), needed))
        found[:, first:] = fine[:, : needed - first]
        return found


def _summed_states(turn: Complex, n: int, ends: tuple[Complex, ...], driven: Complex) -> Complex:
    """(kept, lines) DFT of states s[k + 1] = step s[k] + u[k].

    Args:
        turn: (lines,) of a sample.
        n: samples.
        ends: (kept,) first state, last state, step.
        driven: (kept, lines) DFT of u.
    """
    first, last, step = (each[:, None] for each in ends)
    return (first - step * last * turn**n + turn * driven) / (1 - step * turn)


def _dft_of_phases(phases: Real, lines: Real, n: int) -> Complex:
    """(f, every, lines) DFT, as of n samples, of each phase of (f, samples, every)."""
    rows = np.moveaxis(phases, 1, 2)
    if len(lines) > n // 16:
        whole: Complex = np.fft.rfft(rows, n)[..., np.abs(lines).astype(int)]
        return np.where(lines < 0, np.conj(whole), whole)
    both = rows @ _dft_rows(phases.shape[1], n, lines.tobytes())
    return both[..., : len(lines)] + 1j * both[..., len(lines) :]


# Up to 0.3 MB each: as many as a campaign has sines.
@lru_cache(maxsize=160)
def _dft_rows(samples: int, n: int, lines: bytes) -> Real:
    """(samples, 2 lines) by which samples add up to their DFT: real parts, then imaginary ones."""
    turns: Complex = np.exp(-2j * np.pi / n * np.outer(np.arange(samples), np.frombuffer(lines)))
    return np.concatenate([turns.real, turns.imag], axis=1).astype(np.float64, copy=False)


def _filter_reach(every: int) -> int:
    """Steps to either side of a sample that its filter reaches."""
    return REACH * every if every > 1 else 0


@lru_cache(maxsize=16)
def _filter_taps(every: int) -> Real:
    if every == 1:
        return np.ones(1)
    at = np.arange(-REACH * every, REACH * every + 1) / every
    taps = np.sinc(at) * np.kaiser(at.size, 8.0)
    return taps / taps.sum()
