"""Rigs for trials: steel links of many sizes, with ten accelerometers and a shaker as on the demonstration's."""

from datetime import date

import numpy as np

from modallab.core.rig import Beam, Channel, Converter, Limits, Point, Rig, Tolerance
from modallab.core.units import STANDARD_GRAVITY

LENGTH_M = (0.8, 1.2)
WIDTH_M = (0.04, 0.06)
FIRST_HZ = (4.2, 6.2)
"""Of the nominal beam, rigidly clamped: its thickness follows."""
TURNED = 1 / 3
"""Share of accelerometers that are mounted against the drive, and of those that are given in g."""
POINTS = range(1, 11)
CALIBRATED = date(2025, 1, 15)


def drawn_rig(seed: int) -> Rig:
    """A link that a seed draws, with a point at each tenth of its length; only its beam is not known exactly."""
    rng = np.random.default_rng([seed, 77])
    length, width = round(float(rng.uniform(*LENGTH_M)), 3), round(float(rng.uniform(*WIDTH_M)), 4)
    modulus, density = float(rng.choice([195e9, 205e9, 210e9])), 7850.0
    first = float(rng.uniform(*FIRST_HZ))
    thickness = 2 * np.pi * first * length**2 / 1.875104**2 * np.sqrt(12 * density / modulus)
    return Rig(
        name=f"link {seed}",
        bench="sim://cantilever",
        beam=Beam(
            length_m=length,
            width_m=width,
            thickness_m=round(float(thickness), 5),
            youngs_modulus_pa=modulus,
            density_kg_m3=density,
        ),
        tolerance=Tolerance(youngs_modulus=0.012, thickness=0.003, density=0.003),
        shaker_point=4,
        points=tuple(Point(id=k, x_m=length * k / 10) for k in POINTS),
        converter=Converter(),
        limits=Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=20.0, acceleration_m_s2=95.0, max_burst_s=60.0),
        channels=(_force_channel(), *(_accelerometer(k) for k in POINTS)),
    )


def _force_channel() -> Channel:
    return Channel(
        index=0,
        name="force",
        quantity="force",
        unit="N",
        sensitivity_v_per_unit={"impact": 0.02, "sine": 0.5},
        range_v=10.0,
        serial="FT-0001",
        calibrated_on=CALIBRATED,
    )


def _accelerometer(k: int) -> Channel:
    return Channel(
        index=k,
        name=f"a{k:02d}",
        quantity="acceleration",
        unit="m/s^2",
        point=k,
        sensitivity_v_per_unit={"impact": 0.01, "sine": 0.1},
        range_v=10.0,
        serial=f"AC-{k:04d}",
        calibrated_on=CALIBRATED,
    )


def with_other_mounting(rig: Rig, seed: int) -> Rig:
    """The rig as labs write it down: some accelerometers are mounted against the drive, some are given in g."""
    rng = np.random.default_rng([seed, 80])
    return rig.model_copy(update={"channels": tuple(_mount_channel(c, rng) for c in rig.channels)})


def _mount_channel(channel: Channel, rng: np.random.Generator) -> Channel:
    turned, in_g = rng.random(2) < TURNED
    if channel.quantity != "acceleration":
        return channel
    own: dict[str, object] = {"direction": "-z" if turned else "+z"}
    if in_g and isinstance(channel.sensitivity_v_per_unit, dict):
        volts = {test: value * STANDARD_GRAVITY for test, value in channel.sensitivity_v_per_unit.items()}
        own |= {"unit": "g", "sensitivity_v_per_unit": volts}
    return channel.model_copy(update=own)
