"""Sensitivities from what is known: gravity, a shunt, a reference shaker, a mass. Pure functions of recordings."""

from datetime import date
from math import copysign
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.hardware import Calibration, MassRatio
from modallab.core.rig import Channel, Rig
from modallab.core.units import STANDARD_GRAVITY, si_factor
from modallab.signals.conversion import volts_per_si
from modallab.signals.tone_fit import fit_frequency

Volts = NDArray[np.float64]
Method = Literal["turnover", "shunt", "reference", "rigid-mass"]

MIN_STEP = 10.0
"""A step must stand so many times above what its mean is known to."""


def sensitivity_by_turnover(up: Volts, down: Volts) -> tuple[float, float]:
    """V per m/s^2 and its sigma from (n,) volts with the sensor's axis up, then down: twice gravity apart."""
    return sensitivity_by_step(down, up, 2 * STANDARD_GRAVITY)


def sensitivity_by_step(without: Volts, with_: Volts, step: float) -> tuple[float, float]:
    """V per unit and its sigma from (n,) volts without and with a known step, as a shunt resistor makes one.

    Raises:
        DataError: the step can't be seen.
    """
    found = float(with_.mean() - without.mean())
    sigma = float(np.hypot(with_.std() / np.sqrt(with_.size), without.std() / np.sqrt(without.size)))
    if abs(found) < MIN_STEP * sigma or found == 0:
        raise DataError(
            f"the step is {found:.3g} V, known to {sigma:.2g} V: no step was detected",
            remedy="use DC coupling, check that the sensor was turned or the shunt closed, and record longer",
        )
    return found / step, sigma / abs(step)


def sensitivity_by_reference(volts: Volts, rate_hz: float, frequency_hz: float, rms: float) -> tuple[float, float]:
    """V per unit and its sigma from (n,) volts on a reference shaker of a known rms value.

    Raises:
        DataError: there is no such sine.
    """
    fit = fit_frequency(volts[None, :], rate_hz, frequency_hz)
    amplitude, noise = float(np.abs(fit.amplitude[0])), float(fit.residual_rms[0])
    sigma = noise * np.sqrt(2 / volts.size)
    if amplitude < MIN_STEP * sigma:
        raise DataError(f"no sine at {frequency_hz:g} Hz", remedy="switch the reference shaker on")
    return amplitude / (rms * np.sqrt(2)), float(sigma) / (rms * np.sqrt(2))


def sensitivity_by_rigid_mass(force_volts: Volts, acceleration: Volts, mass_kg: float) -> tuple[float, float]:
    """V per N and its sigma from (n,) volts of a force transducer that shakes a free mass, and its m/s^2.

    Least squares of the volts on m a, as F = m a.

    Raises:
        DataError: the two do not go together.
    """
    newton = mass_kg * (acceleration - acceleration.mean())
    volts = force_volts - force_volts.mean()
    power = float(newton @ newton)
    slope = float(volts @ newton) / power if power > 0 else 0.0
    rest = volts - slope * newton
    if not power or float(rest @ rest) > 0.1 * float(volts @ volts):
        raise DataError(
            "force and acceleration are not those of one rigid mass",
            remedy="excite below the first resonance of mass and fixture, and check both cables",
        )
    return slope, float(np.sqrt((rest @ rest) / max(1, volts.size - 1) / power))


def with_calibration(
    rig: Rig,
    channel: Channel,
    method: Method,
    per_si: tuple[float, float],
    on: date,
    remark: str = "",
) -> Rig:
    """The rig with a calibration in its history, and the channel's sensitivity and date set to it.

    Where the channel has a sensitivity for each test, that of the impact test alone is set. The sign stays what the
    rig file says: how a sensor is mounted is no matter of its calibration.

    Args:
        rig: as before.
        channel: that was calibrated.
        method: how.
        per_si: V per SI unit, and sigma.
        on: the day.
        remark: anything else.
    """
    factor = si_factor(channel.quantity, channel.unit, channel.name)
    value = copysign(per_si[0] * factor, channel.sensitivity("impact"))
    sigma = per_si[1] * factor
    entry = Calibration(
        date=on,
        channel=channel.name,
        serial=channel.serial,
        method=method,
        sensitivity_v_per_unit=value,
        sigma_v_per_unit=sigma,
        remark=remark,
        test="impact",
    )
    before = channel.sensitivity_v_per_unit
    sensitivity = {**before, "impact": value} if isinstance(before, dict) else value
    new = channel.model_copy(update={"sensitivity_v_per_unit": sensitivity, "calibrated_on": on})
    channels = tuple(new if c.index == channel.index else c for c in rig.channels)
    return rig.model_copy(update={"channels": channels, "history": (*rig.history, entry)})


def measure_mass_ratio(
    rig: Rig, volts: NDArray[np.float64], sensor: Channel, mass_kg: float, when: Literal["before", "after"], on: date
) -> MassRatio:
    """The ratio from (channels, n) volts while the free mass is struck or shaken, with the sensitivities of the rig.

    Raises:
        DataError: force and acceleration are not those of one rigid mass.
    """
    per_si = volts_per_si(rig, "impact")
    force = rig.force_channel.index
    acceleration = volts[sensor.index] / per_si[sensor.index]
    slope, sigma = sensitivity_by_rigid_mass(volts[force], acceleration, mass_kg)
    believed = abs(per_si[force])
    return MassRatio(
        date=on,
        when=when,
        channel=sensor.name,
        mass_kg=mass_kg,
        ratio=float(abs(slope) / believed),
        sigma=float(sigma / believed),
    )
