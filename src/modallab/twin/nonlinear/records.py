"""What an element adds to the motion of the modes in a record: a hit, or a sine from its start on."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.modes import TwinModes
from modallab.twin.nonlinear.element import ModalCoupling, NonlinearLaw
from modallab.twin.nonlinear.steps import ElementForces, ModalSteps

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


PER_PERIOD = 36
"""Steps a period of a sine, where there may be as many."""
HIT_STEPS = 8
"""Steps a sample of a hit."""
LEAST = {NonlinearLaw.CUBIC: 2, NonlinearLaw.DRAG: 1, NonlinearLaw.PLAY: 8, NonlinearLaw.CRACK: 3}
"""Steps a sample of a sine at least: fewer where a law is smooth, more where a stiff contact strikes; 4 otherwise."""
MOST = 8
"""Steps a sample of a sine at most."""


def prepared_steps(modes: TwinModes, own: ModalCoupling, dt: float, x_m: float) -> Callable[[int], ModalSteps]:
    """Steps of a beam and an element, so many a sample of `dt` s, driven at `x_m`: made ready once for many records."""

    @lru_cache(maxsize=MOST)
    def steps(every: int) -> ModalSteps:
        return ModalSteps.of(modes, own, dt / every, x_m)

    return steps


def element_response_in_hit(steps: Callable[[int], ModalSteps], pulse: Real, first: int, n: int) -> FineSteps:
    """What the element adds to a hit.

    Args:
        steps: of the beam and the element.
        pulse: (m,) force in N about the hit.
        first: sample at which the pulse begins.
        n: samples of the record.
    """
    begin = max(0, first - 32)
    record = np.zeros(n)
    record[first : first + len(pulse)] = pulse[: n - first]
    spectrum = np.fft.rfft(record)
    fine = np.asarray(np.fft.irfft(spectrum, n * HIT_STEPS) * HIT_STEPS, dtype=np.float64)
    still_after = np.zeros(REACH * HIT_STEPS)
    force = np.concatenate([fine[begin * HIT_STEPS :], still_after])
    return FineSteps(steps(HIT_STEPS).run(force, 0), HIT_STEPS, 0, n, begin)


def element_response_in_sine(
    steps: Callable[[int], ModalSteps],
    law: NonlinearLaw,
    amplitude_n: complex,
    frequency_hz: float,
    n: int,
    dt: float,
    history_s: float,
    ramp_s: float,
    cosine: bool,
    coarse: bool = False,
) -> FineSteps:
    """What it adds to a sine block that began `history_s` before, rising for `ramp_s` from rest.

    Coarse is in half of the steps.
    """
    from modallab.twin.nonlinear.sampling import rising_sine

    every = int(np.clip(np.ceil(PER_PERIOD * frequency_hz * dt), LEAST.get(law, 4), MOST))
    every = -(-every // 2) if coarse else every
    h = dt / every
    skip = round(history_s / h)
    force = np.empty(skip + (n - 1 + REACH) * every + 1)
    # Straight lines between the steps of a sine are that much smaller than the sine.
    larger = complex(amplitude_n / np.sinc(frequency_hz * h) ** 2)
    rising_sine(
        larger, 2 * np.pi * frequency_hz * h, float(skip), history_s / h - skip, max(ramp_s, 1e-6) / h, cosine, force
    )
    # Every step about the record is kept, and what rings above its band taken out as a converter does.
    before = min(skip, REACH * every)
    return FineSteps(steps(every).run(force, skip - before), every, before, n)


def added_acceleration(modes: TwinModes, own: ModalCoupling, psi: Complex, added: FineSteps, dt: float) -> Real:
    """(points, n) m/s^2 that it adds where the modes' shapes are `psi` (points, p)."""
    motion, force = added.sampled()
    p = len(motion)
    straight = 2 * np.real((psi[:, :p] * modes.poles[:p]) @ own.shapes[:, :p].T)
    total = 2 * np.real((psi[:, :p] * modes.poles[:p] ** 2) @ motion) + straight @ force.T
    # What follows at once: its static motion, twice differentiated.
    static = -2 * np.real((psi[:, p:] / modes.poles[p:]) @ own.shapes[:, p:].T)
    second_derivative = np.gradient(np.gradient(force, dt, axis=0), dt, axis=0)
    return total + static @ second_derivative.T
