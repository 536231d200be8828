"""What is known of a sensor from elsewhere: its certificate, and what a rigid mass said before and after a test."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Annotated, Literal

from pydantic import Field

from modallab.core.frozen import Finite, Frozen, NonNegative, Positive

Day = date


class Certificate(Frozen):
    """A calibration certificate of a sensor, or of a sensor with its preamplifier.

    Attributes:
        serial: of the sensor.
        number: of the certificate.
        laboratory: that issued it.
        date: of the calibration.
        expires: last day it is valid; left out: no end is stated.
        reference: standard it was calibrated against.
        reference_hz: frequency of the sensitivity.
        temperature_c: at which it was calibrated.
        sensitivity_v_per_unit: certified, in V per unit of the channel; its sign says nothing of the mounting.
        uncertainty_percent: expanded, k = 2, of the sensitivity.
    """

    serial: Annotated[str, Field(min_length=1)]
    number: str = ""
    laboratory: str = ""
    date: date
    expires: Day | None = None
    reference: str = ""
    reference_hz: Positive | None = None
    temperature_c: Finite | None = None
    sensitivity_v_per_unit: Finite | None = None
    uncertainty_percent: Positive

    @property
    def relative_sigma(self) -> float:
        """One standard deviation, relative."""
        return self.uncertainty_percent / 200


class MassRatio(Frozen):
    """Force over mass times acceleration of a free rigid mass, by the rig's own sensitivities: 1 if they are right.

    ISO 7626-5 asks for it before and after a test with an impact hammer.

    Attributes:
        date: day it was measured.
        when: before or after the test.
        channel: of the accelerometer on the mass.
        mass_kg: of the free mass, with the accelerometer on it.
        ratio: of the magnitudes.
        sigma: of it.
    """

    date: date
    when: Literal["before", "after"]
    channel: str
    mass_kg: Positive
    ratio: Positive
    sigma: NonNegative


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


def judge_mass_ratios(ratios: Sequence[MassRatio]) -> list[Judgement]:
    """The last ratio of each accelerometer before and after a test, each against 1 and the two against each other."""
    found: list[Judgement] = []
    for channel in dict.fromkeys(ratio.channel for ratio in ratios):
        last = {ratio.when: ratio for ratio in ratios if ratio.channel == channel}
        found += [_against_one(ratio) for ratio in last.values()]
        if "before" in last and "after" in last:
            found.append(_sensitivity_drift(last["before"], last["after"]))
    return found


def _against_one(ratio: MassRatio) -> Judgement:
    what = f"rigid-mass ratio {ratio.when} the test, {ratio.channel} on {ratio.mass_kg:g} kg: {ratio.ratio:.4f}"
    allowed = f"1 within {100 * MOST_ERROR:g} % is allowed"
    return Judgement(f"{what} +- {ratio.sigma:.1g}; {allowed}", abs(ratio.ratio - 1) <= MOST_ERROR)


def _sensitivity_drift(before: MassRatio, after: MassRatio) -> Judgement:
    drift = after.ratio / before.ratio - 1
    what = f"rigid-mass ratio of {before.channel} from before to after: {100 * drift:+.2f} %"
    return Judgement(f"{what}; {100 * MOST_DRIFT:g} % are allowed", abs(drift) <= MOST_DRIFT)
