"""The blocks of one test of one rig: what they must be, and some of their channels."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from modallab.core.array_checks import check_signals
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.signals.faults.whole_channels import constant_channels
from modallab.signals.signals import Signals


def check_outputs(signals: Signals, rig: Rig) -> None:
    """Reject signals of other outputs than the rig's: points and units would be another's.

    Raises:
        DataError: they are not the rig's, in its order.
    """
    names = tuple(c.name for c in rig.responses)
    if signals.outputs != names:
        raise DataError(
            f"outputs {list(signals.outputs)} are not the rig's {list(names)}",
            where=f"record {signals.block.name}",
            remedy="use the rig file the record was made with",
        )


def check_test(signals: Sequence[Signals]) -> None:
    """Reject blocks that make no test: none at all, unequal ones, or blocks that no living bench records.

    Raises:
        DataError: as said, with the record's name.
    """
    if not signals:
        raise DataError("there is no block", remedy="give the blocks of one test")
    shapes = {(s.rate_hz, s.n_samples, s.outputs) for s in signals}
    if len(shapes) > 1:
        listed = "; ".join(sorted(f"{n} samples of {len(o)} outputs at {rate:g} Hz" for rate, n, o in shapes))
        raise DataError(f"the blocks of one test differ: {listed}", remedy="identify each kind of block separately")
    for s in signals:
        where = f"record {s.block.name}"
        rows = np.vstack([s.forces, s.responses])
        for force in (names := _named_forces(s)):
            check_signals(rows, (*names, *s.outputs), where, force=force)
        if dead := constant_channels(rows, (*names, *s.outputs), names):
            raise DataError(
                "; ".join(map(str, dead)), where=where, remedy="leave the channel out of rig file and record"
            )
    driven = {s.block.driven_points for s in signals if len(s.forces) > 1}
    if len(driven) > 1 or (driven and min(len(s.forces) for s in signals) == 1):
        raise DataError(
            f"the blocks were driven at other points: {'; '.join(map(str, driven))}, or by one shaker",
            remedy="identify each set of shakers separately",
        )


def _named_forces(signals: Signals) -> tuple[str, ...]:
    """What each force is called where it is found to be dead."""
    if len(signals.forces) == 1:
        return ("force",)
    return tuple(f"force at point {point}" for point in signals.block.driven_points)


@dataclass(frozen=True, eq=False, slots=True)
class ChosenOutputs:
    """The forces and some outputs.

    Attributes:
        rig: with these channels only.
        rows: where they stand in the whole rig's blocks.
    """

    rig: Rig
    rows: tuple[int, ...]

    @classmethod
    def of(cls, rig: Rig, outputs: tuple[str, ...] = ()) -> Self:
        """The outputs of these names, in the rig's order; all of them if none is named.

        Raises:
            DataError: there is no such output.
        """
        known = tuple(c.name for c in rig.responses)
        unknown = sorted(set(outputs) - set(known))
        if unknown:
            raise DataError(f"there is no output {', '.join(unknown)}", remedy=f"choose from {', '.join(known)}")
        forces = {rig.force_channel.index, *(c.index for c in rig.forces)}
        chosen = [c for c in rig.channels if not outputs or c.name in outputs or c.index in forces]
        kept = tuple(c.model_copy(update={"index": n}) for n, c in enumerate(chosen))
        return cls(rig.model_copy(update={"channels": kept}), tuple(c.index for c in chosen))

    def block(self, block: Block) -> Block:
        """These channels of a block of the whole rig."""
        return block.with_channels(self.rows)
