"""Every number that decides which effects are proposed, each with its meaning, unit, default and reason."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of the inference.

    Attributes:
        frequency_share: discrepancy of a natural frequency per unit of that of a modal constant, a pure number. A
            frequency is predicted ten times as well as an amplitude by any finite-element model of a beam.
        damping_share: the same of a damping ratio, which joints and cables change more than anything else.
        degrees_of_freedom: of Student's t distribution of each row. 5 keeps a single wrong row from deciding, and
            differs little from the normal distribution for all others (Lange, Little and Taylor, J. Am. Stat. Assoc.
            84, 1989, 881).
        smallest_scale: smallest standard deviation of the discrepancy, as a share of the response. No model of a real
            bench is more exact than a thousandth; what lies below is left to the records.
        expected_error: error of the twin that is expected before a campaign, as a share of the response. Virtual
            benches by others are that near; how much more it is on a real one its records show.
        scales: how many values of a scale are compared, evenly on logarithms up to 1.
        node: a modal constant below this share of its mode's rms over the channels is compared with that share.
        effect_price: what one effect more must gain, in -2 log evidence: prior odds of 1 to 400.
        most_effects: effects in one explanation.
        first: starts of each screen that are fitted in a round, over all candidates.
        starts: starts of one candidate, at most.
        rivals: explanations of a round that are fitted to the records.
        top_hz: poles are identified up to this frequency, Hz; the hammer's pulse carries little beyond it.
    """

    frequency_share: float = 0.1
    damping_share: float = 3.0
    degrees_of_freedom: float = 5.0
    smallest_scale: float = 1e-3
    expected_error: float = 3e-4
    scales: int = 13
    node: float = 0.3
    effect_price: float = 12.0
    most_effects: int = 3
    first: int = 16
    starts: int = 3
    rivals: int = 3
    top_hz: float = 390.0

    @property
    def scale_values(self) -> NDArray[np.float64]:
        """(scales,) the values of a scale that are compared."""
        return np.geomspace(self.smallest_scale, 1.0, self.scales)


DEFAULT = Settings()
