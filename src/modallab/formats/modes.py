"""Modes as other programs hand them on: frequencies, damping and shapes, without uncertainty or modal constants."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, slots=True)
class ModeShapes:
    """Modes of one model.

    Attributes:
        title: what the file says of them.
        frequency_hz: (modes,) undamped natural frequencies.
        damping_ratio: (modes,) of critical damping.
        outputs: (outputs,) channels of the rig that the shapes are at.
        output_points: (outputs,) their points.
        modal_mass_kg: (modes,) that belongs to the shapes as they are scaled here; NaN where the file does not say.
        shapes: (modes, outputs) complex, scaled as in the file, positive along the drive, as readings are.
    """

    title: str
    frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    modal_mass_kg: NDArray[np.float64]
    shapes: NDArray[np.complex128]
