"""Modes as other programs hand them on, without uncertainty: at channels of a rig, or at the nodes of a model."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

Units = Literal["m", "mm"]
"""Of length; with mm the mass is in tonnes, as those who compute in N and mm have it."""


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


@dataclass(frozen=True, eq=False, slots=True)
class NodeModes:
    """Real modes of an undamped model.

    Attributes:
        title: what they are of.
        frequency_hz: (modes,) natural frequencies, rising; about 0 for motions of the whole.
        at: node -> (modes, 3) motion along x, y, z at unit modal mass, kg^-1/2.
        places_m: node -> x, y, z in m; empty where the file does not say.
        damping_ratio: (modes,) of critical damping; NaN where the file does not say.
    """

    title: str
    frequency_hz: Real
    at: dict[int, Real]
    places_m: dict[int, tuple[float, float, float]]
    damping_ratio: Real


def in_si(modes: NodeModes, units: Units) -> NodeModes:
    """Modes of a model in metres and kilograms from those of one in other units."""
    if units == "m":
        return modes
    length, mass = 1e-3, 1e3
    return replace(
        modes,
        at={node: motion / np.sqrt(mass) for node, motion in modes.at.items()},
        places_m={node: (x * length, y * length, z * length) for node, (x, y, z) in modes.places_m.items()},
    )
