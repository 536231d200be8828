"""Where and how is measured: points, channels, and the converter behind them."""

from datetime import date
from typing import Annotated, Literal, Self

from pydantic import Field, PositiveInt, model_validator

from modallab.core.errors import RigError
from modallab.core.field_errors import reject_problems
from modallab.core.frozen import Finite, Frozen, NonNegative, Positive, is_not_stated
from modallab.core.hardware import Certificate
from modallab.core.rig_checks import channel_problems
from modallab.core.units import BROADBAND, Quantity, Test

Direction = Literal["+x", "-x", "+y", "-y", "+z", "-z"]


def _is_at_zero(value: object) -> bool:
    """Whether a coordinate is where points on a beam have it: then it is not written."""
    return value == 0


class Point(Frozen):
    """A measurement point on the structure.

    Attributes:
        id: number, unique on the rig.
        x_m: coordinate x; on a beam the distance from the clamp.
        y_m: coordinate y; a beam lies along x.
        z_m: coordinate z.
    """

    id: PositiveInt
    x_m: Finite
    y_m: Finite = Field(default=0.0, exclude_if=_is_at_zero)
    z_m: Finite = Field(default=0.0, exclude_if=_is_at_zero)


class Channel(Frozen):
    """One channel of the measurement chain: transducer, preamplifier, input.

    Attributes:
        index: position in the rig, from 0.
        name: unique name.
        quantity: measured quantity.
        unit: unit of the measured quantity, such as N, m/s^2 or g.
        point: number of the sensor's point.
        direction: direction of positive readings; the force channel's is that of the drive by default.
        mass_kg: of the sensor.
        sensitivity_v_per_unit: sensitivity, or one for each test; None if unknown: 1 V per unit is then assumed.
        coupling: coupling of the input; IEPE and bridge also supply the sensor.
        range_v: range of the input, if it differs from the converter's.
        serial: serial number of the sensor.
        calibrated_on: date of its calibration.
        input: the device's own name of the input, such as `cDAQ1Mod1/ai0`; empty: the next input in order.
        excitation_v: supply voltage of a bridge sensor.
        excitation_a: supply current of an IEPE sensor.
        ac_corner_hz: corner of the first-order AC coupling; 0 for DC.
        delay_s: delay of the samples to the motion, as by a converter's digital filter.
        skew_s: delay to channel 0 by a multiplexer.
        certificate: certificate of the sensor.
    """

    index: Annotated[int, Field(ge=0)]
    name: Annotated[str, Field(min_length=1)]
    quantity: Quantity
    unit: str
    point: PositiveInt | None = None
    direction: Direction = "+z"
    mass_kg: NonNegative = 0.0
    sensitivity_v_per_unit: Finite | dict[Test, Finite] | None = Field(default=None, exclude_if=is_not_stated)
    coupling: Literal["DC", "AC", "IEPE", "bridge"] = "DC"
    range_v: Positive | None = None
    serial: str = ""
    calibrated_on: date | None = None
    input: str = ""
    excitation_v: Positive | None = None
    excitation_a: Positive | None = None
    ac_corner_hz: NonNegative = 0.0
    delay_s: NonNegative = 0.0
    skew_s: NonNegative = 0.0
    certificate: Certificate | None = Field(default=None, exclude_if=is_not_stated)

    def sensitivity(self, test: Test) -> float:
        """Volts per unit in a test; the preamplifier may stand differently in each."""
        value = self.sensitivity_v_per_unit
        if value is None:
            return 1.0
        if isinstance(value, float | int):
            return float(value)
        if test not in value and test in BROADBAND and "sine" in value:
            # The shaker drives in both, and nobody turns the preamplifiers between.
            return value["sine"]
        if test not in value:
            raise RigError(
                f"no sensitivity for the {test} test, only for {', '.join(value) or 'none'}",
                where=f"channel {self.name}",
                remedy=f"add sensitivity_v_per_unit: {{{test}: ...}} to the rig file",
            )
        return value[test]

    @model_validator(mode="after")
    def _check(self) -> Self:
        reject_problems(channel_problems(self.model_dump()))
        return self


class Converter(Frozen):
    """The analog-to-digital converter behind every channel.

    Attributes:
        bits: resolution.
        range_v: full scale, either sign.
        noise_rms_v: noise of one sample.
    """

    bits: Annotated[int, Field(ge=8, le=32)] = 16
    range_v: Positive = 10.0
    noise_rms_v: NonNegative = 0.0003

    @property
    def volts_per_count(self) -> float:
        """Volts of one count, full scale +-range_v."""
        return self.range_v / 2 ** (self.bits - 1)
