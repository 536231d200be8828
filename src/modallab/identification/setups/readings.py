"""What each set-up read of every mode of the joined model, for the table that holds them side by side."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.setups.compare import ComparedSetUp
from modallab.identification.setups.found import SetUpModel


@dataclass(frozen=True, eq=False, slots=True)
class SetUpReading:
    """One set-up's own frequencies and damping ratios of the modes that all set-ups have.

    Attributes:
        name: of the set-up.
        frequency_hz: (modes,)
        frequency_sigma_hz: (modes,) NaN where the method states none.
        damping_ratio: (modes,)
        damping_sigma: (modes,)
        off: (modes,) whose frequency, or amplitude at the reference, differs from that of the set-up it was compared
            with by more than chance; see `compare_setups`.
        against: name of that set-up; its own for the one that the others were compared with.
    """

    name: str
    frequency_hz: Real
    frequency_sigma_hz: Real
    damping_ratio: Real
    damping_sigma: Real
    off: NDArray[np.bool_]
    against: str


def readings_of_setups(
    found: Sequence[SetUpModel], modes: NDArray[np.int64], compared: Sequence[ComparedSetUp]
) -> tuple[SetUpReading, ...]:
    """What each set-up read.

    Args:
        found: the set-ups.
        modes: (set-ups, modes) places of the same modes, as `same_modes`.
        compared: as `compare_setups`.
    """
    return tuple(
        SetUpReading(
            item.name,
            item.model.frequency_hz[at],
            item.model.frequency_sigma_hz[at],
            item.model.damping_ratio[at],
            item.model.damping_sigma[at],
            other.shift_off | other.ratio_off,
            other.against,
        )
        for item, at, other in zip(found, modes, compared, strict=True)
    )
