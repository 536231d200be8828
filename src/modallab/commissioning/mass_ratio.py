"""The rigid-mass ratio before and after a test (ISO 7626-5): the whole chain held against Newton's second law."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.commissioning.calibrate import by_rigid_mass
from modallab.core.metrology import MassRatio
from modallab.core.rig import Channel, Rig
from modallab.signals.conversion import volts_per_si

MOST_ERROR = 0.05
"""The ratio may differ from 1 by so much."""

MOST_DRIFT = 0.01
"""The ratio after a test may differ from that before by so much."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """One limit.

    Attributes:
        what: in words, with values and limit.
        within: whether it is kept.
    """

    what: str
    within: bool


def measured(
    rig: Rig, volts: NDArray[np.float64], sensor: Channel, mass_kg: float, when: Literal["before", "after"], on: date
) -> MassRatio:
    """The ratio from (channels, n) volts while the free mass is struck or shaken, with the sensitivities of the rig.

    Raises:
        DataError: force and acceleration do not go together as those of one rigid mass.
    """
    per_si = volts_per_si(rig, "impact")
    force = rig.force_channel.index
    acceleration = volts[sensor.index] / per_si[sensor.index]
    slope, sigma = by_rigid_mass(volts[force], acceleration, mass_kg)
    believed = abs(per_si[force])
    return MassRatio(
        date=on,
        when=when,
        channel=sensor.name,
        mass_kg=mass_kg,
        ratio=float(abs(slope) / believed),
        sigma=float(sigma / believed),
    )


def judged(
    ratios: Sequence[MassRatio], most_error: float = MOST_ERROR, most_drift: float = MOST_DRIFT
) -> list[Judgement]:
    """The last ratio of each accelerometer before and after a test, each against 1 and the two against each other."""
    found: list[Judgement] = []
    for channel in dict.fromkeys(ratio.channel for ratio in ratios):
        last = {ratio.when: ratio for ratio in ratios if ratio.channel == channel}
        found += [_against_one(ratio, most_error) for ratio in last.values()]
        if "before" in last and "after" in last:
            found.append(_drift(last["before"], last["after"], most_drift))
    return found


def _against_one(ratio: MassRatio, most: float) -> Judgement:
    what = f"rigid-mass ratio {ratio.when} the test, {ratio.channel} on {ratio.mass_kg:g} kg: {ratio.ratio:.4f}"
    return Judgement(f"{what} +- {ratio.sigma:.1g}; 1 within {100 * most:g} % is allowed", abs(ratio.ratio - 1) <= most)


def _drift(before: MassRatio, after: MassRatio, most: float) -> Judgement:
    drift = after.ratio / before.ratio - 1
    what = f"rigid-mass ratio of {before.channel} from before to after: {100 * drift:+.2f} %"
    return Judgement(f"{what}; {100 * most:g} % are allowed", abs(drift) <= most)
