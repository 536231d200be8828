"""The sensors before a run: what they and their certificates say, and waiting until fed ones have settled.

A contradiction to the rig file is no rig to measure with. The bias of a fed sensor is some 10 V; after a coupling of
0.35 Hz it takes 3 s until a few mV are left. The mean of a window under a Hann weight shows what is left of it, since a
ringing beam hardly reaches that mean. While the bias fades, means of neighbouring windows differ by more than twice the
scatter within a window, however slow it is; noise makes them differ by less than a tenth.
"""

import re
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from modallab.bench.capabilities import ReadsSensitivities, ReadsSerialNumbers, SuppliesSensors
from modallab.bench.protocol import Bench
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test, si_factor

TEDS_PERCENT = 5.0
"""A sensor's own sensitivity may differ so much where no certificate says how well it is known."""
Pull = Callable[[int], NDArray[np.generic]]
"""Reads the next so many samples: (channels, n) as delivered."""

_WINDOW_S = 0.5
_WINDOWS = 4
"""So many windows before are compared, since a slow bias moves little from one to the next."""

_STEADY = 0.3
"""Largest difference of means, in scatters of a window."""

PATIENCE_S = 60.0
"""Low-frequency sensors discharge with 10 s; after six of these it is no bias that fades."""


@dataclass(frozen=True, slots=True)
class SensorRemark:
    """One thing that was compared with another.

    Attributes:
        channel: of the rig.
        what: was found, with its values.
        contradiction: whether one of the two must be wrong; else a person should know it.
    """

    channel: str
    what: str
    contradiction: bool


def sensor_remarks(rig: Rig, test: Test, today: date, bench: Bench | None = None) -> list[SensorRemark]:
    """Everything that is expired or contradicts itself, channel by channel.

    Args:
        rig: with the certificates.
        test: sets the sensitivities.
        today: a certificate is valid to the end of its last day.
        bench: open, not running, to ask the sensors themselves; None: they are not asked.
    """
    serials = bench.read_serials() if isinstance(bench, ReadsSerialNumbers) else {}
    sensed = bench.read_sensitivities() if isinstance(bench, ReadsSensitivities) else {}
    found: list[SensorRemark] = []
    for channel in rig.channels:
        name = channel.name
        found += [SensorRemark(name, what, contradiction=False) for what in _expiry_remark(channel, today)]
        wrong = [
            *_other_serial(channel, serials),
            *_other_sensitivity(channel, rig, test),
            *_other_sensed(channel, test, sensed),
        ]
        found += [SensorRemark(name, what, contradiction=True) for what in wrong]
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
        found.append(f"the rig file has the sensor {channel.serial}, its TEDS states {sensed}")
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
        f"and its uncertainty is {certificate.uncertainty_percent:g} %"
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
        f"the rig file has {believed:.5g} V per SI unit, its TEDS states {sensed[channel.name]:.5g}: "
        f"{percent:+.2g} %, {allowed:g} % are allowed"
    ]


@dataclass(frozen=True, slots=True)
class SensorSettling:
    """What waiting came to.

    Attributes:
        seconds: waited.
        unsettled: channels whose bias still moved at the end.
    """

    seconds: float
    unsettled: tuple[str, ...]


def supplied_channels(bench: Bench, rig: Rig) -> dict[int, str]:
    """Channels, by their place in the rig, whose sensors this bench feeds."""
    fed = set(bench.supplied_channels()) if isinstance(bench, SuppliesSensors) else set[str]()
    return {channel.index: channel.name for channel in rig.channels if channel.name in fed}


def wait_until_settled(
    pull: Pull, fed: Mapping[int, str], rate_hz: float, patience_s: float = PATIENCE_S
) -> SensorSettling:
    """Read until the bias of no fed channel moves any more, at most so long; nothing is read where none is fed.

    Args:
        pull: reads on.
        fed: names of the channels by row.
        rate_hz: at which the samples come.
        patience_s: at most to wait.
    """
    if not fed:
        return SensorSettling(0.0, ())
    rows, count = list(fed), max(16, round(_WINDOW_S * rate_hz))
    weight = np.hanning(count + 2)[1:-1]
    weight /= weight.sum()
    before: deque[NDArray[np.float64]] = deque(maxlen=_WINDOWS)
    moving = np.ones(len(rows), dtype=np.bool_)
    for n in range(1, max(2, int(patience_s / _WINDOW_S)) + 1):
        window = pull(count)[rows].astype(np.float64)
        mean = window @ weight
        if before:
            moving = np.abs(mean - np.array(before)).max(axis=0) > _STEADY * window.std(axis=1)
            if not moving.any():
                return SensorSettling(n * _WINDOW_S, ())
        before.append(mean)
    return SensorSettling(patience_s, tuple(fed[row] for row, left in zip(rows, moving, strict=True) if left))
