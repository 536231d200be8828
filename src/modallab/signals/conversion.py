"""From the numbers a device delivers, or a file holds, to SI units in the structure's axis, and back.

This is the only place that knows a channel's sensitivity, unit and direction, and where its range ends. Positive is
the drive's direction, for the force and for every response: a sensor mounted against it is turned here.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import DERIVATIVE, Test, is_voltage, si_factor

Samples = NDArray[Any]

DEFAULT_BITS = 16
"""Resolution of a converter of which the rig file says nothing."""


@dataclass(frozen=True, eq=False, slots=True)
class Conversion:
    """How to read the samples of one test.

    Attributes:
        names: (channels,) of the rig.
        si_per_count: (channels,) SI units of the channel's quantity per delivered number, positive along the drive.
        full_scale: (channels,) magnitude in delivered numbers from which on a sample is an overload; infinite if
            unknown.
        forces: indices of the force channels, each shaker's, the first one's first; none where no force was measured.
        responses: indices of all other channels, in rig order.
        motion: indices of the channels that sense motion.
    """

    names: tuple[str, ...]
    si_per_count: Real
    full_scale: Real
    forces: tuple[int, ...]
    responses: tuple[int, ...]
    motion: tuple[int, ...]

    @classmethod
    def of(cls, rig: Rig, test: Test, units: Sequence[str], scale: Real, dtype: np.dtype[Any] | None = None) -> Self:
        """The conversion of a rig's channels in a test.

        Args:
            rig: sensitivities, units, directions and ranges.
            test: which sensitivities hold.
            units: (channels,) of the delivered numbers times `scale`: volts, or a unit of the channel's quantity.
            scale: (channels,) unit per delivered number.
            dtype: of the samples; whole numbers end at their type's largest.

        Raises:
            RigError: a channel has no sensitivity for this test.
            DataError: a unit that is none of the channel's quantity.
        """
        rows = list(zip(rig.channels, units, scale, strict=True))
        last = np.inf if dtype is None or dtype.kind not in "iu" else float(np.iinfo(dtype).max)
        return cls(
            names=tuple(c.name for c in rig.channels),
            si_per_count=np.array([sign_of(rig, c) * float(s) * _si_per_unit(c, unit, test) for c, unit, s in rows]),
            full_scale=np.array([min(last, _full_scale(rig, c, unit, float(s))) for c, unit, s in rows]) * (1 - 1e-9),
            forces=tuple(c.index for c in rig.forces),
            responses=tuple(c.index for c in rig.responses),
            motion=tuple(c.index for c in rig.responses if c.quantity in DERIVATIVE),
        )

    @classmethod
    def of_block(cls, block: Block, rig: Rig) -> Self:
        """The conversion of a block's samples; errors as for `of`, with the record's name."""
        try:
            return cls.of(rig, block.test, block.units, block.scale, block.samples.dtype)
        except DataError as error:
            raise DataError(error.what, where=f"record {block.name}, {error.where}", remedy=error.remedy) from error

    @property
    def force(self) -> int:
        """Index of the first shaker's force channel, which is the hammer's as well.

        Raises:
            DataError: no force was measured.
        """
        if not self.forces:
            raise DataError("no force was measured", remedy="identify the responses alone (--response-only)")
        return self.forces[0]

    def to_si(self, samples: Samples) -> Real:
        """(channels, n) delivered numbers in SI units along the drive; delays and AC coupling as they are."""
        return samples.astype(np.float64) * self.si_per_count[:, None]

    def force_n(self, samples: Samples) -> Real:
        """(n,) force in N, positive along the drive, of (channels, n) delivered numbers; zeros if none was measured.

        Of several it is the first shaker's.
        """
        if not self.forces:
            return np.zeros(samples.shape[1])
        return samples[self.force].astype(np.float64) * self.si_per_count[self.force]

    def forces_n(self, samples: Samples) -> Real:
        """(forces, n) all forces in N, positive along the drive, of (channels, n) delivered numbers."""
        rows = list(self.forces)
        return samples[rows].astype(np.float64) * self.si_per_count[rows, None]

    def overloaded_channels(self, samples: Samples) -> NDArray[np.bool_]:
        """(channels,) whether any of the (channels, n) delivered numbers is at full scale."""
        return largest_magnitudes(samples) >= self.full_scale


def largest_magnitudes(samples: Samples) -> Real:
    """(channels,) largest magnitude; in real numbers, since the most negative int16 has no positive counterpart."""
    return np.maximum(samples.max(axis=1).astype(np.float64), -samples.min(axis=1).astype(np.float64))


def volts_per_si(rig: Rig, test: Test) -> Real:
    """(channels,) V per SI unit along the drive: negative for a sensor that is mounted against it.

    Raises:
        RigError: a channel has no sensitivity for this test.
    """
    return np.array([sign_of(rig, c) / _si_per_unit(c, "V", test) for c in rig.channels])


def volts_per_count(rig: Rig, test: Test, units: Sequence[str], scale: Real) -> Real:
    """(channels,) V at the converter per delivered number, whatever unit that is in; direction plays no part.

    Raises:
        RigError: a channel has no sensitivity for this test.
        DataError: a unit that is none of the channel's quantity.
    """
    rows = zip(rig.channels, units, scale, strict=True)
    return np.array([float(s) * _volts_per_unit(c, unit, test) for c, unit, s in rows])


def unit_per_si(rig: Rig) -> Real:
    """(channels,) the channel's own unit and direction per SI unit along the drive: what it would be read as."""
    return np.array([sign_of(rig, c) / si_factor(c.quantity, c.unit, f"channel {c.name}") for c in rig.channels])


def block_in_volts(block: Block, rig: Rig) -> Block:
    """The block as its converter saw it: what came in physical units or mV is turned into V.

    Raises:
        RigError: a channel has no sensitivity for this test.
        DataError: a unit that is none of the channel's quantity.
    """
    if all(unit == "V" for unit in block.units):
        return block
    scale = volts_per_count(rig, block.test, block.units, block.scale)
    return replace(block, scale=scale, units=("V",) * len(block.units))


def sign_of(rig: Rig, channel: Channel) -> float:
    """1 for a channel that reads positive along the drive, -1 for one that is mounted against it.

    A channel across the drive has no such sign and is left as it is; see `require_one_axis`.
    """
    across = channel.direction[1] != rig.drive_direction[1]
    return 1.0 if across or channel.direction[0] == rig.drive_direction[0] else -1.0


def require_one_axis(rig: Rig, where: str = "") -> None:
    """Reject channels of a beam that measure across the drive: their motion is none of this test's.

    Raises:
        DataError: names the first of them.
    """
    for channel in rig.channels if rig.model == "cantilever" else ():
        if channel.direction[1] != rig.drive_direction[1] and channel.quantity in ("force", *DERIVATIVE):
            raise DataError(
                f"measures along {channel.direction}, the beam is driven along {rig.drive_direction}",
                where=f"{where + ', ' if where else ''}channel {channel.name}",
                remedy="leave the channel out, or correct its direction in the rig file",
            )


def _si_per_unit(channel: Channel, unit: str, test: Test) -> float:
    where = f"channel {channel.name}"
    if is_voltage(unit) and channel.quantity != "voltage":
        volts = si_factor("voltage", unit, where)
        return volts / channel.sensitivity(test) * si_factor(channel.quantity, channel.unit, where)
    return si_factor(channel.quantity, unit, where)


def _volts_per_unit(channel: Channel, unit: str, test: Test) -> float:
    where = f"channel {channel.name}"
    if is_voltage(unit):
        return si_factor("voltage", unit, where)
    own = si_factor(channel.quantity, unit, where) / si_factor(channel.quantity, channel.unit, where)
    return own * channel.sensitivity(test)


def _full_scale(rig: Rig, channel: Channel, unit: str, scale: float) -> float:
    range_v = channel.range_v or (rig.converter.range_v if rig.converter is not None else None)
    if range_v is None or not is_voltage(unit):
        return np.inf
    bits = rig.converter.bits if rig.converter is not None else DEFAULT_BITS
    return range_v * (1 - 2.0 ** (1 - bits)) / abs(scale * si_factor("voltage", unit))
