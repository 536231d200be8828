"""A block in SI units: step A of the paper, and what is found in it at once, its hit or its tone."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_rate
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.signals.ac_coupling import undo_ac_coupling
from modallab.signals.alignment import align_channels, lags_s
from modallab.signals.checks import check_block, check_rows
from modallab.signals.conversion import Conversion, require_one_axis
from modallab.signals.hit import HitSamples, find_hit, windowed_force
from modallab.signals.tone_fit import SineFit, fit_tone


@dataclass(frozen=True, eq=False)
class Signals:
    """Force and responses of one block, positive along the drive, validated when they are made.

    Attributes:
        forces: (inputs, n) in N, one row for each force that drove, in the order of the block's `driven_points`; a
            row of zeros where none was measured. (n,) stands for one row.
        responses: (outputs, n) in SI units of each output's quantity.
        rate_hz: sampling rate.
        outputs: (outputs,) channel names.
        block: the block it came from.

    Raises:
        DataError: no rate, shapes that do not belong together, values that are no finite numbers.
    """

    forces: Real
    responses: Real
    rate_hz: float
    outputs: tuple[str, ...]
    block: Block

    def __post_init__(self) -> None:
        where = f"record {self.block.name}"
        check_rate(self.rate_hz, where)
        if self.forces.ndim == 1:
            object.__setattr__(self, "forces", self.forces[None])
        shape = self.responses.shape
        if self.forces.ndim != 2 or not len(self.forces) or shape != (len(self.outputs), self.forces.shape[1]):
            raise DataError(
                f"force {self.forces.shape}, responses {shape} and {len(self.outputs)} outputs do not belong together",
                where=where,
                remedy="give forces (inputs, n) and responses (outputs, n), one row for each output",
            )
        check_rows(self.forces, f"force of {where}")
        check_rows(self.responses, f"responses of {where}")

    @property
    def force(self) -> Real:
        """(n,) in N, of a record that one force drove.

        Raises:
            DataError: several did: the responses are not those of one alone.
        """
        if len(self.forces) > 1:
            points = " and ".join(map(str, self.block.driven_points))
            raise DataError(
                f"the points {points} were driven at the same time, but this needs a single force",
                where=f"record {self.block.name}",
                remedy="identify the record (modallab identify), or record with one shaker (shakers: first)",
            )
        return self.forces[0]

    @property
    def n_samples(self) -> int:
        """Samples of each row."""
        return self.forces.shape[1]

    @cached_property
    def hit(self) -> HitSamples:
        """Where the hit lies in the force.

        Raises:
            DataError: no sample stands out of the noise.
        """
        return find_hit(self.force)

    @cached_property
    def hit_force(self) -> Real:
        """(n,) force in N without its offset, zero outside the hit."""
        return windowed_force(self.force, self.hit)

    @cached_property
    def tone(self) -> SineFit:
        """The sine in the force, at its own frequency, which the generator's clock decides.

        Raises:
            DataError: the record has no frequency, or its force no such sine.
        """
        return fit_tone(self.force, self.rate_hz, self.block.frequency_hz, f"record {self.block.name}")


def to_signals(block: Block, rig: Rig) -> Signals:
    """Scale a block to SI units; invert sensors mounted against the drive, remove delays, undo AC coupling.

    Args:
        block: as delivered, channels in rig order.
        rig: sensitivities, units, directions, delays and corners.

    Raises:
        DataError: channels other than the rig's, a unit that is not the channel's, a scale of nothing, a channel across
            the drive, or samples that are no records.
    """
    check_block(block, rig)
    require_one_axis(rig, f"record {block.name}")
    conversion = Conversion.of_block(block, rig)
    values = undo_ac_coupling(conversion.to_si(block.samples), block.rate_hz, rig, block.frequency_hz)
    values = align_channels(values, block.rate_hz, lags_s(rig))
    return Signals(
        forces=values[forces_of(block, conversion)] if conversion.forces else np.zeros(block.n_samples),
        responses=values[list(conversion.responses)],
        rate_hz=block.rate_hz,
        outputs=tuple(c.name for c in rig.responses),
        block=block,
    )


def forces_of(block: Block, conversion: Conversion) -> list[int]:
    """Places of the force channels that drove a block, in the order of its `driven_points`.

    Raises:
        DataError: the rig has fewer.
    """
    count = len(block.driven_points)
    if len(conversion.forces) < count:
        raise DataError(
            f"{count} forces drove, and the rig has {len(conversion.forces)} force channels",
            where=f"record {block.name}",
            remedy="use the rig file the record was made with",
        )
    return list(conversion.forces[:count])


def to_signals_of(blocks: Sequence[Block], rig: Rig) -> list[Signals]:
    """`to_signals` for several blocks, which must share rate and length.

    Raises:
        DataError: the blocks differ in rate or length.
    """
    shapes = {(b.rate_hz, b.n_samples) for b in blocks}
    if len(shapes) > 1:
        listed = ", ".join(f"{n} samples at {rate:g} Hz" for rate, n in sorted(shapes))
        raise DataError(f"the blocks of one test differ: {listed}", remedy="identify each kind in a separate campaign")
    return [to_signals(b, rig) for b in blocks]
