"""The rig's abort limits, looked at in every chunk while the shaker may move."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Chunk
from modallab.core.errors import SafetyError
from modallab.core.rig import Channel, Limits, Rig
from modallab.core.units import SI_UNIT
from modallab.signals.conversion import Conversion, largest_magnitudes
from modallab.storage.samples import Samples


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

    def __call__(self, chunk: Chunk) -> None:
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
            remedy="lower the drive level or stay clear of the resonance; the blocks before are kept",
        )

    def used(self, samples: Samples) -> float:
        """The largest part of a limit that any of the (channels, n) samples takes."""
        return float((largest_magnitudes(samples) / self.limit).max())


def watch_of(rig: Rig, limits: Limits, conversion: Conversion) -> LimitWatch:
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
