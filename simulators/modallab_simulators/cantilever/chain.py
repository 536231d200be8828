"""Preamplifiers and converter: what each row sees of the beam, and the counts made from it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Channel, Converter, Rig
from modallab.core.units import Test, si_factor
from modallab_simulators.cantilever.effect_part import ChainChanges
from modallab_simulators.cantilever.loads import SensorOutput
from modallab_simulators.cantilever.sensor import SensorTransfer

_ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2}


def outputs_of(rig: Rig, changes: ChainChanges) -> tuple[SensorOutput, ...]:
    """One output per row, in rig order.

    Raises:
        ConfigurationError: a response without a point, a force transducer across the drive, a sensor with mass.
    """
    for force in (rig.force_channel, *rig.forces[1:]):
        if force.direction[1] != rig.drive_direction[1]:
            raise ConfigurationError(
                f"measures along {force.direction}, the drive is along {rig.drive_direction}",
                where=f"channel {force.name}",
                remedy="turn the force transducer into the drive's direction",
            )
    sensors = sensor_rows(rig, changes)
    return tuple(_output(rig, rig.channels[sensor], row, changes) for row, sensor in enumerate(sensors))


def sensor_rows(rig: Rig, changes: ChainChanges) -> list[int]:
    """Which channel's sensor is wired to each row."""
    rows = list(range(len(rig.channels)))
    for one, other in changes.exchanged:
        rows[one], rows[other] = rows[other], rows[one]
    return rows


def _output(rig: Rig, channel: Channel, row: int, changes: ChainChanges) -> SensorOutput:
    if channel.mass_kg:
        raise ConfigurationError(
            f"mass_kg is {channel.mass_kg}",
            where=f"channel {channel.name}",
            remedy="the simulated sensors have none: 0; the effect sensor_mass gives them one",
        )
    later = row * changes.skew_s
    if channel.quantity == "force":
        shaker = next(n for n, force in enumerate(rig.forces) if force.name == channel.name)
        return SensorOutput("force", later_s=later, shaker=shaker)
    if channel.quantity == "voltage":
        return SensorOutput("voltage", later_s=later)
    if channel.point is None:
        raise ConfigurationError(
            f"a {channel.quantity} that stands at no point",
            where=f"channel {channel.name}",
            remedy="give the channel a point",
        )
    later += changes.delay_s
    x_m = rig.x_of(channel.point) + changes.moved_m.get(channel.index, 0.0)
    return SensorOutput("motion", x_m, _ORDER[channel.quantity], later, _sensor(channel, changes))


def _sensor(channel: Channel, changes: ChainChanges) -> SensorTransfer:
    sensor = SensorTransfer()
    if channel.quantity != "acceleration":
        return sensor
    for row, own in changes.filters:
        if row is None or row == channel.index:
            sensor = sensor.followed_by(own)
    return sensor


@dataclass(frozen=True, slots=True)
class MainsHum:
    """The mains on every row: volts (0.5 + 0.1 k) in row k."""

    volts: float = 0.0
    hz: float = 50.0
    phase: float = 0.0

    def on(self, rows: int, times_s: Real) -> Real:
        """In V, (rows, times)."""
        wave = np.sin(2 * np.pi * self.hz * times_s + self.phase)
        return np.multiply.outer(self.volts * (0.5 + 0.1 * np.arange(rows)), wave)


@dataclass(frozen=True, eq=False, slots=True)
class RandomErrors:
    """What chance does to a stretch of samples.

    Attributes:
        noise: (rows, n) of unit variance.
        lost: (rows, n) which samples are lost, or None.
        late: (n,) how late each instant is, in its own standard deviation, or None.
    """

    noise: NDArray[np.float32]
    lost: NDArray[np.bool_] | None = None
    late: Real | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Chain:
    """The chain of all rows, in rig order.

    Attributes:
        volts_per_si: (rows,) sensitivity in V per SI unit, signed by the sensor's direction.
        volts_per_count: (rows,)
        noise_rms_v: (rows,) white noise before the converter.
        low: smallest count.
        high: largest count.
        dtype: of the counts.
        clip_v: (rows,) beyond which a row goes no further.
        hum: the mains.
        knee_v: (rows,) towards which a row saturates softly.
        lost_share: (rows,) of the samples.
        jitter_s: standard deviation of every instant.
        curves: row -> what it reads of what it would read, both in V.
        holds: rows that read the sample before in place of a lost one.
    """

    volts_per_si: Real
    volts_per_count: Real
    noise_rms_v: Real
    low: int
    high: int
    dtype: np.dtype[np.generic]
    clip_v: Real
    hum: MainsHum
    knee_v: Real
    lost_share: Real
    jitter_s: float
    curves: Mapping[int, Callable[[Real], Real]]
    holds: frozenset[int]

    @classmethod
    def of(cls, rig: Rig, test: Test, changes: ChainChanges) -> Self:
        """The chain of a rig in a test, nothing clipped yet.

        Raises:
            RigError: a channel has no sensitivity for this test.
        """
        converter = rig.converter or Converter()
        sensors = [rig.channels[sensor] for sensor in sensor_rows(rig, changes)]
        full, rows = 2 ** (converter.bits - 1), range(len(rig.channels))
        return cls(
            np.array([_volts_per_si(rig, c, test) * _gain(c, changes) for c in sensors]),
            np.array([(c.range_v or converter.range_v) / full for c in rig.channels]),
            np.array([converter.noise_rms_v * changes.noise.get(row, 1.0) for row in rows]),
            -full,
            full - 1,
            np.dtype(np.int16 if converter.bits <= 16 else np.int32),
            np.full(len(rig.channels), inf),
            MainsHum(),
            np.array([changes.knee_v.get(row, inf) for row in rows]),
            np.array([changes.lost_share.get(row, 0.0) for row in rows]),
            changes.jitter_s,
            changes.curves,
            changes.holds,
        )

    def clipped(self, row: int, level_v: float) -> Self:
        """The same, with one row cut at a level."""
        levels = self.clip_v.copy()
        levels[row] = level_v
        return replace(self, clip_v=levels)

    def draw(self, noise: np.random.Generator, flaws: np.random.Generator, count: int) -> RandomErrors:
        """What chance does to the next `count` samples; the noise is the same whatever flaws the bench has."""
        rows = len(self.volts_per_si)
        lost = flaws.random((rows, count)) < self.lost_share[:, None] if self.lost_share.any() else None
        late = flaws.standard_normal(count) if self.jitter_s else None
        return RandomErrors(noise.standard_normal((rows, count), dtype=np.float32), lost, late)

    def convert(self, seen: Real, luck: RandomErrors, times_s: Real) -> NDArray[np.generic]:
        """Counts of what the rows see in SI units at some times, both (rows, n).

        Raises:
            ConfigurationError: a row sees what is no number; as counts it would be 0.
        """
        if not np.all(np.isfinite(seen)):
            row = int(np.flatnonzero(~np.isfinite(seen).all(axis=1))[0])
            raise ConfigurationError(
                f"row {row} of the simulated bench has NaN values from {times_s[0]:.3f} s on",
                remedy="make the effects smaller: the structure is unstable",
            )
        if luck.late is not None:
            seen = seen + np.gradient(seen, times_s, axis=1) * (self.jitter_s * luck.late)
        counts = seen * (self.volts_per_si / self.volts_per_count)[:, None]
        for row in np.flatnonzero(np.isfinite(self.knee_v)):
            counts[row] /= np.sqrt(1 + (counts[row] * self.volts_per_count[row] / self.knee_v[row]) ** 2)
        for row, curve in self.curves.items():
            counts[row] = curve(counts[row] * self.volts_per_count[row]) / self.volts_per_count[row]
        counts += luck.noise * (self.noise_rms_v / self.volts_per_count).astype(np.float32)[:, None]
        if self.hum.volts:
            counts += self.hum.on(len(seen), times_s) / self.volts_per_count[:, None]
        for row in np.flatnonzero(np.isfinite(self.clip_v)):
            level = self.clip_v[row] / self.volts_per_count[row]
            np.clip(counts[row], -level, level, out=counts[row])
        if luck.lost is not None:
            replace_lost_samples(counts, luck.lost, self.holds)
        np.rint(counts, out=counts)
        np.clip(counts, self.low, self.high, out=counts)
        return counts.astype(self.dtype)

    def overload(self, samples: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Which rows stand at a full scale anywhere in `samples`, (rows,)."""
        return np.any((samples == self.high) | (samples == self.low), axis=1)


def replace_lost_samples(counts: Real, lost: NDArray[np.bool_], holds: frozenset[int]) -> None:
    """Write what stands in place of lost samples: 0, or in rows that hold it the sample before, both (rows, n)."""
    for row in np.flatnonzero(np.any(lost, axis=1)):
        if int(row) in holds:
            last = np.maximum.accumulate(np.where(lost[row], 0, np.arange(lost.shape[1])))
            counts[row] = counts[row, last]
        else:
            counts[row, lost[row]] = 0.0


def _volts_per_si(rig: Rig, channel: Channel, test: Test) -> float:
    volts = channel.sensitivity(test) / si_factor(channel.quantity, channel.unit, channel.name)
    # The beam bends in the plane of the drive only: a sensor across it sees no motion.
    if channel.direction[1] != rig.drive_direction[1]:
        return 0.0
    return volts if channel.direction[0] == rig.drive_direction[0] else -volts


def _gain(channel: Channel, changes: ChainChanges) -> float:
    return changes.force_gain if channel.quantity == "force" else changes.gain.get(channel.index, 1.0)
