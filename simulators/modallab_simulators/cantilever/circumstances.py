"""How a bench is met, beyond what its address says."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Circumstances:
    """The circumstances of a session at the bench.

    Attributes:
        first_start: how many starts and hits went before, which counts where noise and hits are drawn.
        stretch: how much longer than meant all takes that excites. A converter that runs faster by as much sees the
            same forces as one that is right sees without.
        one_clock: whether the generator runs on the converter's clock, as on one card.
        straight_ramp: whether bursts rise along a straight line, not along a cosine.
        modes: how many modes the beam has in all; None for as many as there are.
        drift_s: bench time over which an ordinary drift runs; None for the usual.
    """

    first_start: int = 0
    stretch: float = 1.0
    one_clock: bool = False
    straight_ramp: bool = False
    modes: int | None = None
    drift_s: float | None = None


EVERYDAY = Circumstances()
"""A bench as its address says."""
