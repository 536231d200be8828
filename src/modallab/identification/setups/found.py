"""The model of one set-up, and which of its modes are those of the others."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import IdentificationError
from modallab.core.model import ModalModel
from modallab.identification.selection.criteria import nearest_partners


@dataclass(frozen=True, eq=False, slots=True)
class SetUpModel:
    """What was identified in one set-up.

    Attributes:
        name: of the set-up.
        model: its modal model.
        masses_kg: (outputs,) of the sensors.
    """

    name: str
    model: ModalModel
    masses_kg: tuple[float, ...]

    @property
    def standing(self) -> dict[str, int | None]:
        """Point by channel name."""
        return dict(zip(self.model.outputs, self.model.output_points, strict=True))


def joined_name(channel: str, point: int | None) -> str:
    """What an output is called in the joined model."""
    return channel if point is None else f"{channel}@{point}"


def same_modes(found: Sequence[SetUpModel]) -> NDArray[np.int64]:
    """(set-ups, modes): where each mode that all set-ups have stands in each, by rising frequency.

    Raises:
        IdentificationError: no mode is in all of them.
    """
    first = found[0].model.frequency_hz
    partners = [nearest_partners(first, item.model.frequency_hz) for item in found]
    common = [row for row in range(first.size) if all(of[row] is not None for of in partners)]
    if not common:
        raise IdentificationError(
            f"no mode is in all set-ups: {', '.join(item.name for item in found)}",
            remedy="identify each by itself, and look at what differs",
        )
    return np.array([[of[row] for row in common] for of in partners], dtype=np.int64)
