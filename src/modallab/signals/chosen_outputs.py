"""Some outputs of a rig and of its blocks: what is looked at live is seldom all of a large rig."""

from dataclasses import dataclass
from typing import Self

from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig


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
        return block.of_rows(self.rows)
