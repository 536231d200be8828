"""Which looks at a burst are normal: nothing in them is near any fault, so none needs to be looked at closer.

A chunk holds many looks where time is virtual, or where a device delivers late. Taken one by one they cost a third of
the time in which a sine test is recorded; together they are a few products of matrices. The tests are those of
`plausibility`, at the same thresholds: a look that is not normal is looked at there, with all that may excuse it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.burst_look import HOP_S, WEAK_LATER_S, BurstWindows, has_drive
from modallab.acquisition.monitor.expected_force import SEEN, ExpectedForce
from modallab.acquisition.monitor.tone_prediction import (
    departs_from_prediction,
    is_dead,
    is_noise_alone,
    predict_later_window,
)
from modallab.core.arrays import Real

FEW = 3
"""Fewer looks than these are taken one by one as quickly."""


@dataclass(frozen=True, eq=False, slots=True)
class NormalRanges:
    """Some looks one after another.

    Attributes:
        first: number of the first.
        normal: (looks,)
        tone: (looks, channels) as `BurstWindows.tone`.
        moments: (looks, channels, channels) what each adds to the moments of the motion.
        learned: samples of each that these hold.
    """

    first: int
    normal: NDArray[np.bool_]
    tone: NDArray[np.complex128]
    moments: Real
    learned: int

    def passes(self, look: BurstWindows) -> bool:
        """Whether the look that has just been gone on to is normal; if so, what it teaches is taken in."""
        place = look.hop - self.first
        if not self.normal[place]:
            return False
        look.places.pass_over(self.moments[place], self.learned)
        look.tone = self.tone[place]
        look.gone = np.zeros_like(look.gone)
        return True


def normal_looks(look: BurstWindows, force: ExpectedForce) -> NormalRanges | None:
    """Of all looks for which the samples have come; None where there are few, or not all windows lie in the burst."""
    ends = look.ends_ready()
    later, weak, learned = look.count(look.later_s), look.count(WEAK_LATER_S), look.count(HOP_S)
    if len(ends) < FEW or not look.holds(ends, max(weak, later + look.gap + max(look.earlier, learned))):
        return None
    latest = look.windows(ends, later)
    before = ends - later - look.gap
    earlier, following = look.drives(before, look.earlier), look.drives(ends, later)
    foreseen = predict_later_window(look.windows(before, look.earlier), earlier, following)
    kept, moments = look.places.kept_to(look.windows(before, learned), latest)
    size = np.sqrt(2) * foreseen.level / look.sigma_v
    suspect = (
        departs_from_prediction(latest, foreseen, look.noise_v)
        | is_dead(latest, foreseen, look.white_v)
        | is_noise_alone(look.windows(ends, weak), look.white_v)
        | ~(size > SEEN)
    )
    normal = kept & ~suspect.any(axis=1) & force.believes(look, foreseen) & has_drive(earlier)
    return NormalRanges(look.hop + 1, normal, size * foreseen.phase, moments, learned)
