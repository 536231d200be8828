"""What the rig file says of the devices, and what is known of a sensor from its certificate or a rigid mass."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Annotated, Literal

from pydantic import Field, PositiveInt

from modallab.core.errors import ConfigurationError
from modallab.core.frozen import Finite, Frozen, NonNegative, Positive
from modallab.core.units import Test

Dialect = Literal["keysight-33500", "keysight-33210", "rigol-dg1000", "siglent-sdg"]


class Excitation(Frozen):
    """Drive of the shaker's amplifier.

    Attributes:
        kind: an analog output of the sampling device, or a separate generator.
        output: the device's name of the output (`cDAQ1Mod4/ao0`), the generator's serial port (`COM3`) or its VISA
            address (`TCPIP0::192.168.0.5::INSTR`, `USB0::...::INSTR`); empty: the first output.
        dialect: command language of the generator.
        baud: baud rate of the serial line.
        watchdog_s: time of the device's own watchdog, which then brings the output to 0 V; null: not used.
        heartbeat_line: digital line that toggles while all is well, for an external relay.
        watchdog_waived: reason to drive an output without the device's watchdog, where a burst ends with the driving
            process and the device has no watchdog.
    """

    kind: Literal["analog-output", "generator"] = "analog-output"
    output: str = ""
    dialect: Dialect | None = None
    baud: PositiveInt = 115200
    watchdog_s: Positive | None = None
    heartbeat_line: str = ""
    watchdog_waived: str = ""


class Shaker(Frozen):
    """A further shaker, besides the first one of `shaker_point` and `excitation`.

    Attributes:
        point: point of the shaker.
        force: name of the channel of its force transducer.
        output: the device's name of its output; empty: the next free output.
    """

    point: PositiveInt
    force: Annotated[str, Field(min_length=1)]
    output: str = ""


def require_guarded(excitation: Excitation | None, where: str) -> None:
    """Reject to drive an analog output whose burst ends with the process that drives it, if nothing was said of that.

    Raises:
        ConfigurationError: there is neither a watchdog nor a reason to go without.
    """
    chosen = excitation or Excitation()
    if chosen.kind != "analog-output" or chosen.watchdog_s is not None or chosen.watchdog_waived.strip():
        return
    raise ConfigurationError(
        "the output holds its last value, not 0 V, if this machine sleeps, crashes or loses the device in a burst,"
        " and the rig file has no watchdog",
        where=where,
        remedy="set excitation.watchdog_s if the device has a watchdog; if it has none, state in "
        "excitation.watchdog_waived another way to end the drive, such as a switch within reach",
    )


class Synchronisation(Frozen):
    """Synchronisation of several devices.

    Attributes:
        method: `one-task`: the driver routes clock and triggers by itself; `reference-clock`: all follow a reference;
            `timebase`: all follow the first one's timebase; `auto`: the first of these that the devices accept.
            `timebase` and `reference-clock` also share the first one's sync pulse and start trigger.
        reference_clock: terminal of the reference, such as `PXIe_Clk100`; empty: that of the backplane.
    """

    method: Literal["auto", "one-task", "reference-clock", "timebase"] = "auto"
    reference_clock: str = ""


class Calibration(Frozen):
    """One calibration of one channel. Entries are only added, never changed.

    `test` is the one whose settings of the preamplifier it holds for; none: it was not noted.

    Attributes:
        date: date of the calibration.
        channel: name of the channel.
        serial: serial number of the sensor.
        method: method of the calibration.
        sensitivity_v_per_unit: sensitivity found.
        sigma_v_per_unit: its standard deviation; 0 if unknown.
        remark: remark in words.
        test: test with the same settings of the preamplifier; None if not noted.
    """

    date: date
    channel: str
    serial: str = ""
    method: Literal["turnover", "shunt", "reference", "rigid-mass"]
    sensitivity_v_per_unit: Finite
    sigma_v_per_unit: NonNegative = 0.0
    remark: str = ""
    test: Test | None = None


Day = date


class Certificate(Frozen):
    """A calibration certificate of a sensor, or of a sensor with its preamplifier.

    Attributes:
        serial: serial number of the sensor.
        number: number of the certificate.
        laboratory: laboratory that issued it.
        date: date of the calibration.
        expires: last day of validity (default: no end).
        reference: reference standard.
        reference_hz: frequency of the sensitivity.
        temperature_c: temperature of the calibration.
        sensitivity_v_per_unit: certified sensitivity, in V per unit of the channel; its sign does not include the
            mounting.
        uncertainty_percent: expanded uncertainty of the sensitivity, k = 2.
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
