"""What certificates and sensors say, compared with the rig file: a contradiction is no rig to measure with."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date

from modallab.bench.abilities import SelfDescribing, SelfNaming
from modallab.bench.protocol import Bench
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test, si_factor

TEDS_PERCENT = 5.0
"""A sensor's own sensitivity may differ so much where no certificate says how well it is known."""


@dataclass(frozen=True, slots=True)
class Remark:
    """One thing that was compared with another.

    Attributes:
        channel: of the rig.
        what: was found, with its values.
        contradiction: whether one of the two must be wrong; else a person should know it.
    """

    channel: str
    what: str
    contradiction: bool


def remarks_on(rig: Rig, test: Test, today: date, bench: Bench | None = None) -> list[Remark]:
    """Everything that is expired or contradicts itself, channel by channel.

    Args:
        rig: with the certificates.
        test: sets the sensitivities.
        today: a certificate is valid to the end of its last day.
        bench: open, not running, to ask the sensors themselves; None: they are not asked.
    """
    serials = bench.sensed_serials() if isinstance(bench, SelfNaming) else {}
    sensed = bench.sensed_sensitivities() if isinstance(bench, SelfDescribing) else {}
    found: list[Remark] = []
    for channel in rig.channels:
        name = channel.name
        found += [Remark(name, what, contradiction=False) for what in _expiry_remark(channel, today)]
        wrong = [
            *_other_serial(channel, serials),
            *_other_sensitivity(channel, rig, test),
            *_other_sensed(channel, test, sensed),
        ]
        found += [Remark(name, what, contradiction=True) for what in wrong]
    return found


def _expiry_remark(channel: Channel, today: date) -> list[str]:
    certificate = channel.certificate
    if certificate is None or certificate.expires is None or certificate.expires >= today:
        return []
    return [
        f"certificate {certificate.number or 'without a number'} of {channel.serial} expired on {certificate.expires}"
    ]


def _other_serial(channel: Channel, serials: Mapping[str, str]) -> list[str]:
    found: list[str] = []
    certificate = channel.certificate
    if certificate is not None and channel.serial and certificate.serial != channel.serial:
        found.append(f"the rig file has the sensor {channel.serial}, its certificate is that of {certificate.serial}")
    sensed = serials.get(channel.name, "")
    if sensed and channel.serial and _serial_number(sensed) != _serial_number(channel.serial):
        found.append(f"the rig file has the sensor {channel.serial}, the sensor itself says (TEDS) {sensed}")
    return found


def _serial_number(serial: str) -> str:
    # A TEDS holds the number only, without the letters and zeros before it.
    digits = re.findall(r"\d+", serial)
    return digits[-1].lstrip("0") if digits else serial.casefold()


def _other_sensitivity(channel: Channel, rig: Rig, test: Test) -> list[str]:
    certificate = channel.certificate
    if certificate is None or certificate.sensitivity_v_per_unit is None:
        return []
    if any(entry.channel == channel.name and entry.date > certificate.date for entry in rig.history):
        # Calibrated on the bench since: that counts.
        return []
    certified, believed = abs(certificate.sensitivity_v_per_unit), abs(channel.sensitivity(test))
    percent = 100 * (believed / certified - 1)
    if abs(percent) <= certificate.uncertainty_percent:
        return []
    return [
        f"the rig file has {believed:.6g} V per {channel.unit}, its certificate {certified:.6g}: {percent:+.3g} %, "
        f"and it is known to {certificate.uncertainty_percent:g} %"
    ]


def _other_sensed(channel: Channel, test: Test, sensed: Mapping[str, float]) -> list[str]:
    if channel.name not in sensed:
        return []
    believed = abs(channel.sensitivity(test)) / si_factor(channel.quantity, channel.unit)
    percent = 100 * (sensed[channel.name] / believed - 1)
    allowed = TEDS_PERCENT if channel.certificate is None else channel.certificate.uncertainty_percent
    if abs(percent) <= allowed:
        return []
    return [
        f"the rig file has {believed:.5g} V per SI unit, the sensor itself says (TEDS) {sensed[channel.name]:.5g}: "
        f"{percent:+.2g} %, {allowed:g} % are allowed"
    ]
