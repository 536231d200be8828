"""The whole bench as the twin believes it: structure, excitation, measurement chain, clock."""

from dataclasses import dataclass, field, replace
from typing import Self, TypeVar

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE, Test
from modallab.twin.modes import TwinModes
from modallab.twin.nonlinear.element import NonlinearElement
from modallab.twin.structure import TwinStructure

S = TypeVar("S", Real, Complex)


@dataclass(frozen=True, slots=True)
class Mount:
    """A loose mount under one accelerometer."""

    channel: int
    hz: float
    zeta: float


@dataclass(frozen=True, eq=False, slots=True)
class MeasurementChain:
    """Linear part of the measurement chain. Channels are numbered as in the rig file, 0 is the force.

    Attributes:
        gain: number -> factor on an accelerometer.
        force_gain: factor on the force.
        swap: two accelerometers whose plugs are exchanged.
        swap_ratio: test -> V per SI unit along the drive of the second's sensor over the first's; 1 if absent.
        shift: number -> m by which an accelerometer sits farther from the clamp.
        corner_hz: first-order high-pass on every accelerometer; 0 for none.
        mounts: loose mounts.
        delay_s: every accelerometer reads what was there that long ago.
        skew_s: row k is sampled k times that much later than row 0.
        integrals: number -> times its sensor integrates the acceleration: 1 for a velocity, 2 for a displacement.
        lag_s: number -> s by which the rig file says that its samples lag.
        own_corner_hz: number -> corner of the AC coupling that the rig file tells of.
        low_pass_hz: (number, corner of a first-order low-pass) of an accelerometer.
    """

    gain: dict[int, float] = field(default_factory=dict[int, float])
    force_gain: float = 1.0
    swap: tuple[int, int] | None = None
    swap_ratio: dict[Test, float] = field(default_factory=dict[Test, float])
    shift: dict[int, float] = field(default_factory=dict[int, float])
    corner_hz: float = 0.0
    mounts: tuple[Mount, ...] = ()
    delay_s: float = 0.0
    skew_s: float = 0.0
    integrals: dict[int, int] = field(default_factory=dict[int, int])
    lag_s: dict[int, float] = field(default_factory=dict[int, float])
    own_corner_hz: dict[int, float] = field(default_factory=dict[int, float])
    low_pass_hz: tuple[tuple[int, float], ...] = ()

    @classmethod
    def of(cls, rig: Rig) -> Self:
        """The chain as the rig file tells of it, its delays and AC coupling undone: what signals in SI units show."""
        missing = {c.index: 2 - DERIVATIVE[c.quantity] for c in rig.responses if c.quantity in DERIVATIVE}
        return cls(integrals={index: count for index, count in missing.items() if count})

    def as_delivered(self, rig: Rig, lags_s: Real) -> Self:
        """The same with the delays (channels,) and the AC coupling of the rig file: what a device delivers."""
        corners = {c.index: c.ac_corner_hz for c in rig.channels}
        # Where all channels share a corner, the measured force has it already.
        own = corners if len(set(corners.values())) > 1 else {}
        stated = {c.index: float(lags_s[c.index]) for c in rig.responses if lags_s[c.index]}
        return replace(
            self,
            lag_s=self.lag_s | {i: lag + self.lag_s.get(i, 0.0) for i, lag in stated.items()},
            own_corner_hz=self.own_corner_hz
            | {i: corner for i, corner in own.items() if corner and i != rig.force_channel.index},
        )


@dataclass(frozen=True, eq=False, slots=True)
class Twin:
    """The bench as a model.

    Attributes:
        structure: the beam.
        chain: the measurement chain.
        ei_drift: relative change of EI from the first record to the last.
        drift_curve: (order over the last order, share of the drift) by which the change went; empty for evenly.
        clock: relative error of the converter's rate.
        hit_shift_m: every hit lands that much farther from the clamp.
        hit_offsets_m: (drive point in m, m) by which hits meant for one point land farther still.
        hit_gains: (drive point in m, factor) on what the beam gets of the hits there.
        shaker_mass_kg: mass on the beam at the shaker point, sine test only.
        stinger_k_rot: rotational stiffness there, N m/rad, sine test only.
        residual_compliance: share of the static compliance of all modes above the twin's own that counts; 1: all.
        element: what of the beam does not answer in proportion; None for nothing.
    """

    structure: TwinStructure
    chain: MeasurementChain = MeasurementChain()
    ei_drift: float = 0.0
    drift_curve: tuple[tuple[float, float], ...] = ()
    clock: float = 0.0
    hit_shift_m: float = 0.0
    hit_offsets_m: tuple[tuple[float, float], ...] = ()
    hit_gains: tuple[tuple[float, float], ...] = ()
    shaker_mass_kg: float = 0.0
    stinger_k_rot: float = 0.0
    residual_compliance: float = 0.0
    element: NonlinearElement | None = None

    def modes_felt_by(self, modes: TwinModes) -> TwinModes:
        """The modes with as much of the static compliance of those above as `element` feels."""
        whole = self.element is not None and self.element.of_all_modes
        return modes if whole else replace(modes, out_of_band=self.residual_compliance * modes.out_of_band)

    def share_of_drift(self, tau: float | Real) -> Real:
        """Share of the drift that has happened at a place in time between 0 and 1."""
        if not self.drift_curve:
            return np.asarray(tau, dtype=np.float64)
        at, share = np.array(self.drift_curve).T
        return np.interp(tau, at, share)

    def struck_x_m(self, drive_x_m: float) -> float:
        """Where hits meant for a point land, on the beam."""
        x = drive_x_m + self.hit_shift_m + dict(self.hit_offsets_m).get(drive_x_m, 0.0)
        return min(max(x, 0.0), self.structure.length_m)

    def hit_gain(self, drive_x_m: float) -> float:
        """What the beam gets of hits meant for a point, over what the hammer reads."""
        return dict(self.hit_gains).get(drive_x_m, 1.0)

    def in_sine(self, shaker_x_m: float) -> TwinStructure:
        """The structure while the shaker hangs on it."""
        s = self.structure
        if self.shaker_mass_kg:
            s = replace(s, masses=(*s.masses, (shaker_x_m, self.shaker_mass_kg)))
        if self.stinger_k_rot:
            s = replace(s, rotation_springs=(*s.rotation_springs, (shaker_x_m, self.stinger_k_rot)))
        return s


def chain_transfer(chain: MeasurementChain, channels: tuple[int, ...], s: Complex) -> Complex:
    """(channels, ...) what the chain makes of an acceleration per measured force at complex frequencies s (...).

    At s = 0 a high-pass and an integral have no answer; there it is 0.
    """
    along = (len(channels), *(1,) * s.ndim)
    gains = np.array([chain.gain.get(channel, 1.0) for channel in channels]) / chain.force_gain
    total: Complex = np.asarray(gains.reshape(along) * np.ones(s.shape), dtype=np.complex128)
    if chain.corner_hz:
        total *= s / (s + 2 * np.pi * chain.corner_hz)
    late = np.array([chain.lag_s.get(c, 0.0) - c * chain.skew_s for c in channels]) + chain.delay_s
    if late.any():
        total *= np.exp(-s * late.reshape(along))
    for i, channel in enumerate(channels):
        if channel in chain.own_corner_hz:
            total[i] *= s / (s + 2 * np.pi * chain.own_corner_hz[channel])
        if channel in chain.integrals:
            total[i] *= np.where(s == 0, 0, 1 / np.where(s == 0, 1, s)) ** chain.integrals[channel]
    for channel, corner_hz in chain.low_pass_hz:
        total[channels.index(channel)] /= 1 + s / (2 * np.pi * corner_hz)
    for mount in chain.mounts:
        omega = 2 * np.pi * mount.hz
        total[channels.index(mount.channel)] *= (2 * mount.zeta * omega * s + omega**2) / (
            s**2 + 2 * mount.zeta * omega * s + omega**2
        )
    return total


def exchange_plugs(chain: MeasurementChain, channels: tuple[int, ...], test: Test, y: S) -> S:
    """The rows (..., channels, n) in SI units with two plugs exchanged, where the chain exchanges them.

    The volts of a sensor, with its sensitivity and its direction, are read as if they were the other's.
    """
    if chain.swap is None:
        return y
    ratio = chain.swap_ratio.get(test, 1.0)
    i, j = (channels.index(c) for c in chain.swap)
    rows = y.copy()
    rows[..., i, :], rows[..., j, :] = y[..., j, :] * ratio, y[..., i, :] / ratio
    return rows


def is_frequency_independent(chain: MeasurementChain) -> bool:
    """Whether the chain is the same on every frequency."""
    return not (
        chain.corner_hz
        or chain.mounts
        or chain.low_pass_hz
        or chain.delay_s
        or chain.skew_s
        or chain.integrals
        or chain.lag_s
        or chain.own_corner_hz
    )
