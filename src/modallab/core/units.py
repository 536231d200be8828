"""Units accepted at the border, each with its factor to SI. Inside, everything is SI."""

from typing import Literal, get_args

from modallab.core.errors import DataError

Quantity = Literal["force", "acceleration", "velocity", "displacement", "pressure", "voltage"]
Broadband = Literal["random", "burst-random", "pseudo-random", "chirp"]
"""What a shaker plays in a broadband test; a record says which, since it decides how an FRF is made of it."""
Test = Literal["impact", "sine", "random", "burst-random", "pseudo-random", "chirp"]
BROADBAND: tuple[Broadband, ...] = get_args(Broadband)
TESTS: tuple[Test, ...] = get_args(Test)
FrfEstimator = Literal["H1", "H2", "Hv"]
"""How an FRF is made of averaged blocks: as if the force, the responses, or neither were exact."""
FRF_ESTIMATORS: tuple[FrfEstimator, ...] = get_args(FrfEstimator)

STANDARD_GRAVITY = 9.80665

TO_SI: dict[Quantity, dict[str, float]] = {
    "force": {
        "N": 1.0,
        "kN": 1e3,
        "MN": 1e6,
        "daN": 10.0,
        "mN": 1e-3,
        "kgf": STANDARD_GRAVITY,
        "lbf": 4.4482216152605,
    },
    "acceleration": {
        "m/s^2": 1.0,
        "m/s2": 1.0,
        "m/s**2": 1.0,
        "cm/s^2": 1e-2,
        "mm/s^2": 1e-3,
        "um/s^2": 1e-6,
        "in/s^2": 0.0254,
        "ft/s^2": 0.3048,
        "g": STANDARD_GRAVITY,
        "mg": 1e-3 * STANDARD_GRAVITY,
    },
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "um/s": 1e-6, "in/s": 0.0254, "ft/s": 0.3048},
    "displacement": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "ft": 0.3048},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "mPa": 1e-3},
    "voltage": {"V": 1.0, "mV": 1e-3},
}
DERIVATIVE: dict[Quantity, int] = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""Times the displacement is differentiated in what a channel senses."""
SI_UNIT: dict[Quantity, str] = {
    "force": "N",
    "acceleration": "m/s^2",
    "velocity": "m/s",
    "displacement": "m",
    "pressure": "Pa",
    "voltage": "V",
}


def si_factor(quantity: Quantity, unit: str, where: str = "") -> float:
    """Factor from `unit` to the SI unit of `quantity`.

    Raises:
        DataError: the unit is not one of this quantity.
    """
    factors = TO_SI[quantity]
    if unit not in factors:
        raise DataError(
            f"unit {unit!r} is no unit of {quantity}",
            where=where,
            remedy=f"use one of {', '.join(factors)}",
        )
    return factors[unit]


def is_voltage(unit: str) -> bool:
    """Whether samples in this unit are still volts, to be scaled by the channel's sensitivity."""
    return unit in TO_SI["voltage"]
