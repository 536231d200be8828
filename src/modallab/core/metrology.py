"""What is known of a sensor from elsewhere: its certificate, and what a rigid mass said before and after a test."""

from datetime import date
from typing import Annotated, Literal

from pydantic import Field, PositiveFloat

from modallab.core.frozen import Frozen

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[PositiveFloat, Field(allow_inf_nan=False)]


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
    expires: date | None = None
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
    sigma: Annotated[float, Field(ge=0, allow_inf_nan=False)]
