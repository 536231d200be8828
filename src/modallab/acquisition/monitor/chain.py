"""From what the device delivers to SI units, channel by channel, and where its range ends."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Delivery
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test, is_voltage, si_factor
from modallab.storage.samples import Samples


@dataclass(frozen=True, eq=False, slots=True)
class Chain:
    """How to read a device's samples.

    Attributes:
        names: (channels,) of the rig.
        si_per_count: (channels,) SI units of the channel's quantity per count.
        full_scale: (channels,) magnitude in counts from which on a sample is beyond the range; infinite if unknown.
        force: index of the force channel.
        motion: indices of the channels that sense motion.
    """

    names: tuple[str, ...]
    si_per_count: NDArray[np.float64]
    full_scale: NDArray[np.float64]
    force: int
    motion: tuple[int, ...]

    def force_n(self, samples: Samples) -> NDArray[np.float64]:
        """Force in N of (channels, n) samples."""
        return samples[self.force] * self.si_per_count[self.force]

    def overload(self, samples: Samples) -> NDArray[np.bool_]:
        """(channels,) whether a sample stands at the end of the converter's range."""
        return peaks(samples) >= self.full_scale


def chain_of(rig: Rig, delivery: Delivery, test: Test) -> Chain:
    """The chain of a rig, configured for a test.

    Raises:
        RigError: a channel has no sensitivity for this test.
        DataError: the device delivers a unit that is none of the channel's quantity.
    """
    pairs = list(zip(rig.channels, delivery.units, delivery.scale, strict=True))
    return Chain(
        names=tuple(channel.name for channel in rig.channels),
        si_per_count=np.array([scale * _si_per_unit(channel, unit, test) for channel, unit, scale in pairs]),
        full_scale=np.array([_full_scale(rig, channel, unit, scale) for channel, unit, scale in pairs]),
        force=rig.force_channel.index,
        motion=tuple(c.index for c in rig.responses if c.quantity != "voltage"),
    )


def peaks(samples: Samples) -> NDArray[np.float64]:
    """(channels,) largest magnitude; in real numbers, since the most negative int16 has no positive counterpart."""
    return np.maximum(samples.max(axis=1).astype(np.float64), -samples.min(axis=1).astype(np.float64))


def _si_per_unit(channel: Channel, unit: str, test: Test) -> float:
    where = f"channel {channel.name}"
    if is_voltage(unit) and channel.quantity != "voltage":
        volts = si_factor("voltage", unit, where)
        return volts / channel.sensitivity(test) * si_factor(channel.quantity, channel.unit, where)
    return si_factor(channel.quantity, unit, where)


def _full_scale(rig: Rig, channel: Channel, unit: str, scale: float) -> float:
    if rig.converter is None or not is_voltage(unit):
        return float("inf")
    range_v = channel.range_v or rig.converter.range_v
    last_v = range_v * (1 - 2.0 ** (1 - rig.converter.bits))
    return last_v / (scale * si_factor("voltage", unit)) * (1 - 1e-9)
