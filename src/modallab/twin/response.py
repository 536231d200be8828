"""What a pole answers to a measured force, on the lines of a block's DFT, ring-down cut off where the block ends.

For a pole l and the displacement residue R the acceleration of a block that holds the whole force f is, on line k,
R (F_k s^2 / (s - l) - l^2 F(l) p^N / (1 - p / z)), s = j omega_k, z = exp(s dt), p = exp(l dt), F(l) the Laplace
transform of the force: the whole response less what rings on after the block. A sine block is its steady state and
the decay that its rise, some seconds before, has left.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.twin.matrices import OWN, stiffness_and_mass
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure


def base_transmission(structure: TwinStructure, x_m: Real, s: Complex) -> Complex:
    """(points, k) absolute acceleration at places on the beam per acceleration of the base, at s (k,).

    Relative motion is that under the inertia load -M 1 of the moving base.
    """
    modes = solve_modes(structure)
    _, mass = stiffness_and_mass(replace(structure, hung=()))
    rigid = np.zeros(OWN)
    rigid[0::2] = 1.0
    load = -(modes.columns.T @ (mass @ rigid))
    out = modes.shapes_at(x_m)
    relative = (out * load) @ (1 / (s - modes.poles[:, None]))
    relative = relative + (out * load).conj() @ (1 / (s - modes.poles.conj()[:, None]))
    return 1 + s**2 * relative


HISTORY_S = 8.0
"""Time from the start of a sine to its block, where nothing else is known."""
RAMP_S = 1.0
"""Its straight rise, where nothing else is known."""
TAIL_SHARE = 0.45
"""Poles beyond this share of the rate leave no tail: nothing in the band excites them."""


def pulse_spectra(pulses: Real, starts: NDArray[np.int64], n: int) -> Complex:
    """(hits, n // 2 + 1) of the pulses alone, each at its place in a block of n samples."""
    windowed = np.zeros((len(pulses), n))
    for row, pulse, start in zip(windowed, pulses, starts, strict=True):
        row[start : start + len(pulse)] = pulse[: n - start]
    return np.fft.rfft(windowed, axis=1)


@dataclass(frozen=True, eq=False, slots=True)
class HitsAtPoint:
    """Hits at one point, taken together: sum conj(F_j) Y_j / sum |F_j|^2 on each line.

    Attributes:
        lines: (k,) DFT lines.
        n: samples of a block.
        dt: seconds.
        pulses: (hits, m) force in N about each hit, zero elsewhere.
        first: (hits,) sample at which each pulse begins.
        weights: (hits, k) conj(F_j) / sum |F_j|^2, F the DFT of the force.
    """

    lines: Real
    n: int
    dt: float
    pulses: Real
    first: NDArray[np.int64]
    weights: Complex

    @property
    def s(self) -> Complex:
        """(k,) j omega of the lines."""
        return 2j * np.pi * self.lines / (self.n * self.dt)

    @property
    def shares(self) -> Complex:
        """(hits, k) what each hit counts of the answer on each line; together 1."""
        return pulse_spectra(self.pulses, self.first, self.n)[:, self.lines.astype(int)] * self.weights

    def on_lines(self, keep: NDArray[np.bool_]) -> Self:
        """Some of the lines."""
        return replace(self, lines=self.lines[keep], weights=self.weights[:, keep])

    def response_to_unit_residue(self, poles: Complex, ratios: Real | None = None) -> tuple[Complex, Complex]:
        """(p, k) of the forced part and of the tail, per unit residue and unit force.

        Args:
            poles: (p,) of the beam.
            ratios: (hits,) factor on the poles at each hit, where the beam is another from one to the next.
        """
        if ratios is not None:
            return self._one_by_one(poles, ratios)
        s = self.s
        forced = s**2 / (s - poles[:, None])
        times = (self.first[:, None] + np.arange(self.pulses.shape[1])) * self.dt
        kept = np.abs(poles) * self.dt < 2 * np.pi * TAIL_SHARE
        p = poles[kept]
        laplace = np.einsum("hm,phm->ph", self.pulses, np.exp(-p[:, None, None] * times)) * self.dt
        decay = np.exp(p * self.dt)
        tail = np.zeros_like(forced)
        shape = -(p**2 * np.exp(p * self.n * self.dt))[:, None] / (1 - decay[:, None] * np.exp(-s * self.dt))
        tail[kept] = shape * (laplace @ self.weights)
        return forced, tail

    def _one_by_one(self, poles: Complex, ratios: Real) -> tuple[Complex, Complex]:
        forced = np.zeros((len(poles), len(self.lines)), dtype=np.complex128)
        tail = np.zeros_like(forced)
        for j, share in enumerate(self.shares):
            own = slice(j, j + 1)
            one = replace(self, pulses=self.pulses[own], first=self.first[own], weights=self.weights[own])
            own_forced, own_tail = one.response_to_unit_residue(poles * ratios[j])
            # A residue goes with the inverse of the frequency.
            forced += own_forced * share / ratios[j]
            tail += own_tail / ratios[j]
        return forced, tail


@dataclass(frozen=True, eq=False, slots=True)
class AveragedFrfs:
    """FRFs of settled records, averaged over bands by the power of the force, which says nothing else of the drive.

    Attributes:
        lines: (k,) DFT line in the middle of each band.
        n: samples of a record.
        dt: seconds.
        fine: (m,) DFT lines that are averaged over, band after band.
        share: (m,) of each in its band; together 1.
        first: (k,) where each band begins among them.
    """

    lines: Real
    n: int
    dt: float
    fine: Real
    share: Real
    first: NDArray[np.int64]

    @property
    def s(self) -> Complex:
        """(k,) j omega of the lines."""
        return 2j * np.pi * self.lines / (self.n * self.dt)

    def on_lines(self, keep: NDArray[np.bool_]) -> Self:
        """Some of the bands."""
        count = np.diff(self.first, append=len(self.fine))
        inside = np.repeat(keep, count)
        first = np.cumsum(count[keep]) - count[keep]
        return replace(self, lines=self.lines[keep], fine=self.fine[inside], share=self.share[inside], first=first)

    def response_to_unit_residue(self, poles: Complex, ratios: Real | None = None) -> tuple[Complex, Complex]:
        """(p, k) of the forced part and of the tail, which is none, per unit residue and unit force."""
        s = 2j * np.pi * self.fine / (self.n * self.dt)
        forced = np.add.reduceat(self.share * s**2 / (s - poles[:, None]), self.first, axis=1)
        return forced, np.zeros_like(forced)


@dataclass(frozen=True, eq=False, slots=True)
class SineStartUp:
    """How each sine came about, out of rest.

    Attributes:
        history_s: (blocks,) from its start to the block.
        ramp_s: (blocks,) how long it rose.
        cosine: (blocks,) whether along (1 - cos(pi t / ramp)) / 2; else along a straight line.
        counted: (blocks,) whether the history was counted in samples, so that the converter's clock stretches it.
    """

    history_s: Real
    ramp_s: Real
    cosine: NDArray[np.bool_]
    counted: NDArray[np.bool_]

    @classmethod
    def usual(cls, blocks: int) -> Self:
        """What is assumed of blocks of which nothing is known."""
        no = np.zeros(blocks, dtype=np.bool_)
        return cls(np.full(blocks, HISTORY_S), np.full(blocks, RAMP_S), no, no)

    def with_clock_error(self, clock: float) -> Self:
        """The same on the clock of the world, where the converter's runs fast by `clock`."""
        return replace(self, history_s=np.where(self.counted, self.history_s / (1 + clock), self.history_s))

    def remaining_transient(self, a: Complex) -> Complex:
        """(..., blocks) transient of a mode with pole a that the start of a sine leaves at the start of the block.

        The steady state 1 / a is not part of it.

        It is minus the integral of the rise's slope times exp(a t), over a. The slope is 1 / T on a straight line,
        pi / (2 T) sin(pi t / T) along a cosine.
        """
        ramp = np.maximum(self.ramp_s, 1e-6)
        late, early = np.exp(-(self.history_s - ramp) * a), np.exp(-self.history_s * a)
        b2 = (np.pi / ramp) ** 2
        along_cosine = b2 / 2 * (late + early) / (a**2 + b2)
        return -np.where(self.cosine, along_cosine, (late - early) / (ramp * a)) / a


@dataclass(frozen=True, eq=False, slots=True)
class SineBlocks:
    """Sine blocks of one length, each on a few lines about its own; scaled by n / 2 times the force amplitude.

    Attributes:
        lines: (blocks, k) DFT lines.
        frequency_hz: (blocks,) what the generator was set to, on the clock of the world.
        n: samples of a block.
        dt: seconds between samples, on the clock of the world.
        force: (blocks,) complex amplitude of the force in N: f(t) = Re(force exp(j omega t)), t from the block's start.
        rise: how the sines came about.
        coarse: whether half of the steps will do where a law is stepped in time: only starts are compared.
    """

    lines: Real
    frequency_hz: Real
    n: int
    dt: float
    force: Complex
    rise: SineStartUp
    coarse: bool = False

    @property
    def s(self) -> Complex:
        """(blocks, k) j omega of the lines."""
        return 2j * np.pi * self.lines / (self.n * self.dt)

    @property
    def drive(self) -> Complex:
        """(blocks,) j omega of the force."""
        return 2j * np.pi * self.frequency_hz

    def shares(self) -> tuple[Complex, Complex]:
        """(blocks, k) what exp(j omega t) and what its conjugate leave on the lines, of n / 2 times the force."""
        turned = (np.conj(self.force) / self.force)[:, None]
        drive = self.drive[:, None]
        return _geometric_sum(drive - self.s, self.dt, self.n) / self.n, turned * _geometric_sum(
            -drive - self.s, self.dt, self.n
        ) / self.n

    def response_to_unit_residue(self, poles: Complex) -> tuple[Complex, Complex, Complex]:
        """Steady gain at +omega and at -omega and amplitude of the decay, (p, blocks) each, per unit residue and force.

        Poles are (p,) or (p, blocks).
        """
        poles = poles if poles.ndim == 2 else np.broadcast_to(poles[:, None], (len(poles), len(self.force)))
        drive = self.drive
        turned = np.conj(self.force) / self.force
        start = (
            self.rise.remaining_transient(drive - poles) + turned * self.rise.remaining_transient(-drive - poles)
        ) / self.n
        return drive**2 / (drive - poles), drive**2 / (-drive - poles), poles**2 * start

    def decay_shape(self, poles: Complex) -> Complex:
        """(p, blocks, k) DFT of exp(pole t) over the block; poles (p,) or (p, blocks)."""
        poles = poles[:, :, None] if poles.ndim == 2 else poles[:, None, None]
        return _geometric_sum(poles - self.s, self.dt, self.n)


def _geometric_sum(a: Complex, dt: float, n: int) -> Complex:
    """Sum of exp(a dt m) for m = 0 ... n - 1."""
    ratio = np.exp(a * dt)
    one = np.abs(ratio - 1) < 1e-12
    return np.where(one, n, (1 - np.exp(a * dt * n)) / np.where(one, 1, 1 - ratio))
