"""Units of abscissae: times in s and frequencies in Hz from what a file says of them."""

import math

from modallab.core.errors import DataError
from modallab.formats.unit_text import normal_unit

_SECONDS = {"": 1.0, "s": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_SECONDS |= {"min": 60.0, "minutes": 60.0, "h": 3600.0, "hr": 3600.0, "hours": 3600.0, "d": 86400.0, "days": 86400.0}
_HERTZ = {"": 1.0, "hz": 1.0, "hertz": 1.0, "cps": 1.0, "cycles/s": 1.0, "khz": 1e3, "rad/s": 0.5 / math.pi}
_HERTZ |= {"cpm": 1 / 60, "cycles/min": 1 / 60, "1/min": 1 / 60}


def to_seconds(unit: str, where: str = "") -> float:
    """What turns times in a unit into seconds; without a unit they are in s.

    Raises:
        DataError: it is no unit of time.
    """
    return _factor(unit, _SECONDS, "time", "s, ms, us, ns, min, h or d", where)


def to_hertz(unit: str, where: str = "") -> float:
    """What turns frequencies in a unit into Hz; without a unit they are in Hz.

    Raises:
        DataError: it is no unit of frequency.
    """
    return _factor(unit, _HERTZ, "frequency", "Hz, kHz, rad/s or cpm", where)


def is_of_time(unit: str) -> bool:
    """Whether a unit, which must be there, is one of time."""
    return bool(unit) and normal_unit(unit).lower() in _SECONDS


def is_of_frequency(unit: str) -> bool:
    """Whether a unit, which must be there, is one of frequency."""
    return bool(unit) and normal_unit(unit).lower() in _HERTZ


def _factor(unit: str, known: dict[str, float], what: str, allowed: str, where: str) -> float:
    factor = known.get(normal_unit(unit).lower())
    if factor is None:
        raise DataError(f"unit {unit!r} is no unit of {what}", where=where, remedy=f"use {allowed}")
    return factor
