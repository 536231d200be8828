"""What is looked at in every chunk while the shaker drives: the limits, and whether the channels can be believed."""

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.plausibility import Plausibility
from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.acquisition.monitor.stream import BenchStream
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.rig import Channel, Limits, Rig
from modallab.core.units import SI_UNIT
from modallab.signals.conversion import Conversion, largest_magnitudes
from modallab.storage.samples import Samples

if TYPE_CHECKING:
    from modallab.acquisition.monitor.motion_limits import MotionWatch
    from modallab.acquisition.monitor.wave_plausibility import WavePlausibility


@dataclass(frozen=True, eq=False, slots=True)
class LimitWatch:
    """Raises on the first chunk beyond a limit.

    Where a limit lies beyond a channel's range it cannot be seen, so the end of the range is taken as beyond it.

    Attributes:
        names: (channels,).
        limit: (channels,) magnitude in counts, infinite where there is no limit.
        si_per_count: (channels,).
        units: (channels,) for the message.
    """

    names: tuple[str, ...]
    limit: NDArray[np.float64]
    si_per_count: NDArray[np.float64]
    units: tuple[str, ...]

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: names every channel beyond its limit, with the number.
        """
        magnitude = largest_magnitudes(chunk.samples)
        # Written so that a sample that is no number is beyond every limit.
        over = np.flatnonzero(~(magnitude <= self.limit))
        if over.size == 0:
            return
        found = ", ".join(
            f"{self.names[c]} {magnitude[c] * self.si_per_count[c]:.4g} {self.units[c]}"
            f" (limit {self.limit[c] * self.si_per_count[c]:.4g})"
            for c in over
        )
        raise SafetyError(
            f"beyond the abort limit: {found}; the output was brought to 0 V",
            remedy="lower the drive level or avoid the resonance; earlier blocks are kept",
        )

    def share_of_limit(self, samples: Samples) -> float:
        """The largest part of a limit that any of the (channels, n) samples takes."""
        return float((largest_magnitudes(samples) / self.limit).max())


def limit_watch(rig: Rig, limits: Limits, conversion: Conversion) -> LimitWatch:
    """The watch for a rig's limits."""
    per_count = np.abs(conversion.si_per_count)
    limit = np.array([_stated_limit(rig, limits, channel) for channel in rig.channels]) / per_count
    visible = np.where(np.isfinite(limit) & (limit >= conversion.full_scale), conversion.full_scale * (1 - 1e-9), limit)
    units = tuple(SI_UNIT[channel.quantity] for channel in rig.channels)
    return LimitWatch(conversion.names, visible, per_count, units)


def _stated_limit(rig: Rig, limits: Limits, channel: Channel) -> float:
    stroke = limits.stroke_m if channel.point in rig.shaker_points else None
    stated = {
        "force": (limits.force_n,),
        "acceleration": (limits.acceleration_m_s2,),
        "velocity": (limits.velocity_m_s,),
        "displacement": (limits.displacement_m, stroke),
    }
    return min((limit for limit in stated.get(channel.quantity, ()) if limit is not None), default=np.inf)


@dataclass(slots=True)
class BurstWatch:
    """Raises on the first chunk with which the drive must end.

    Attributes:
        limits: of what the channels measure.
        plausible: whether they measure at all.
        motion: limits of what must be integrated; None where there are none.
        waves: whether they measure at all, in a drive that is no sine; None where there is none.
        own: noise of each channel at the start of the test.
    """

    limits: LimitWatch
    plausible: Plausibility
    motion: "MotionWatch | None" = None
    waves: "WavePlausibility | None" = None
    own: RestNoise | None = field(default=None)

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk.

        Raises:
            SafetyError: says what is beyond which limit, or which channel cannot be believed.
        """
        self.limits(chunk)
        if self.motion is not None:
            self.motion(chunk)
        self.plausible(chunk)
        if self.waves is not None:
            self.waves(chunk)

    def require_alive(self, rest: Samples, *, counts: bool) -> RestNoise:
        """Look, before a burst, at a (channels, n) window at rest; returns its noise.

        Raises:
            SafetyError: a channel shows less than its own noise.
        """
        noise = RestNoise.of(rest, counts=counts)
        if self.own is None:
            self.own = noise
        dead = self.own.below_earlier_noise(noise) | self.own.ends_frozen(rest)
        below_earlier_noise = np.flatnonzero(dead & np.isfinite(self.limits.limit))
        if below_earlier_noise.size:
            names = ", ".join(self.limits.names[channel] for channel in below_earlier_noise)
            raise SafetyError(
                f"{names} reads less than its own noise: dead or frozen; nothing was driven",
                remedy="check the channel's sensor, cable and input; earlier blocks are kept",
            )
        return noise.with_shorter_runs_of(self.own)

    def begin(self, burst: Burst, start: int, rest: Samples, noise: RestNoise, unseen: int) -> None:
        """A burst begins at sample `start`, after `rest`; `unseen` is the next sample that comes."""
        self.plausible.begin(burst, start, rest, noise, unseen)
        if self.motion is not None:
            self.motion.begin(burst, start)

    def end(self) -> None:
        """The burst has ended, or was ended."""
        self.plausible.end()
        if self.waves is not None:
            self.waves.end()
        if self.motion is not None:
            self.motion.end()

    def restart(self) -> None:
        """The stream begins again."""
        self.end()
        if self.motion is not None:
            self.motion.restart()

    def share_of_limit(self, samples: Samples) -> float:
        """The largest part of a limit that the (channels, n) samples of a burst take."""
        return max(self.limits.share_of_limit(samples), self.motion.share_of_limit if self.motion is not None else 0.0)


def import_motion_limits(limits: Limits | None) -> None:
    """Load what limits of motion need, before the bench is started: a watchdog would not wait for it.

    The filters take more than a second to import, which most tests need not wait for.
    """
    if limits is not None and _limit_motion(limits):
        import_module("modallab.acquisition.monitor.motion_limits")


def _limit_motion(limits: Limits) -> bool:
    return bool(limits.velocity_m_s or limits.displacement_m or limits.stroke_m)


def channels_that_must_move(limits: LimitWatch, conversion: Conversion, driven: int) -> list[int]:
    """Channels with a limit that must move while so many of the shakers drive: all but the others' force channels."""
    still = conversion.forces[driven:]
    return [int(channel) for channel in np.flatnonzero(np.isfinite(limits.limit)) if channel not in still]


def burst_watch(rig: Rig, limits: Limits, conversion: Conversion, stream: BenchStream, lowest_hz: float) -> BurstWatch:
    """The watch for a rig's limits; `lowest_hz` is the lowest frequency that will be driven."""
    watched = limit_watch(rig, limits, conversion)
    plausible = Plausibility(
        conversion.names,
        conversion.si_per_count,
        stream.scale,
        conversion.force,
        channels_that_must_move(watched, conversion, 1),
        stream.rate_hz,
    )
    motion = None
    if _limit_motion(limits):
        from modallab.acquisition.monitor.motion_limits import motion_watch

        motion = motion_watch(rig, limits, conversion, stream.rate_hz, lowest_hz)
    return BurstWatch(watched, plausible, motion)
