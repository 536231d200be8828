"""Units as people and analysers write them, turned into those of `modallab.core.units`."""

import math
import re

from modallab.core.errors import DataError
from modallab.core.frf import UNIT, FrfQuantity
from modallab.core.units import TO_SI, Quantity

_ALIASES = {
    "inch": "in",
    "G": "g",
    "gn": "g",
    "Newton": "N",
    "newton": "N",
    "Newtons": "N",
    "newtons": "N",
    "g's": "g",
    "Gs": "g",
    **dict.fromkeys(("lb", "Lb", "LBF", "lbs", "pounds", "Pounds"), "lbf"),
    "kp": "kgf",
    "Gal": "cm/s^2",
    "Volt": "V",
    "Volts": "V",
    "volt": "V",
    "volts": "V",
    "v": "V",
    "S": "s",
    **dict.fromkeys(("°", "Deg", "DEG", "degree", "Degree", "degrees", "Degrees"), "deg"),
    **dict.fromkeys(("Rad", "RAD", "radian", "Radian", "radians", "Radians"), "rad"),
}
_WHOLE_FRF: dict[str, FrfQuantity] = {
    **{unit: quantity for quantity, unit in UNIT.items()},
    "m/(N*s)": "mobility",
    "m/(N*s^2)": "inertance",
    "m/Ns": "mobility",
    "m/Ns^2": "inertance",
    "1/kg": "inertance",
    "s/kg": "mobility",
    "s^2/kg": "receptance",
    "kg^-1": "inertance",
}
_FRF_OF: dict[Quantity, FrfQuantity] = {
    "displacement": "receptance",
    "velocity": "mobility",
    "acceleration": "inertance",
}


_RAISED = str.maketrans({"⁻": "-", "¹": "1", "³": "^3", "µ": "u", "μ": "u"})
_SECONDS = re.compile(r"(?<![a-z])([mun]?)sec(?:ond)?s?(?=[^a-z]|$)", re.IGNORECASE)
_SQUARED = re.compile(r"/s(?:/s|2)(?=[^\w^]|$)")
_PER = re.compile(r"\s*[·⋅*. ]\s*([A-Za-z]+)\^?-\^?(\d)")
"""A factor with a negative exponent, as in m·s⁻²."""
_TIMES = {"": 1.0, "s": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_TIMES |= {"min": 60.0, "minutes": 60.0, "h": 3600.0, "hr": 3600.0, "hours": 3600.0, "d": 86400.0, "days": 86400.0}
_FREQUENCIES = {"": 1.0, "hz": 1.0, "hertz": 1.0, "cps": 1.0, "cycles/s": 1.0, "khz": 1e3, "rad/s": 0.5 / math.pi}
_FREQUENCIES |= {"cpm": 1 / 60, "cycles/min": 1 / 60, "1/min": 1 / 60}
_OF_PARTS = {"%", "deg", "rad", "dB"}
_IN_UNIT = re.compile(r"^(?P<name>.*?)(?:^|\s)in\s+(?P<unit>\S+)$")
"""A unit as it is spoken, `force in N`."""
_NUMBER = re.compile(r"[+-]?\d[\d.,]*")
"""What stands in brackets behind a name and is no unit."""


def _over(factor: re.Match[str]) -> str:
    return f"/{factor[1]}" if factor[2] == "1" else f"/{factor[1]}^{factor[2]}"


def normal_unit(text: str) -> str:
    """A unit in the project's own spelling; an unknown one as it is. "" for NONE and the like."""
    unit = re.sub(
        r"\s+", " ", text.strip().strip('"').replace("²", "^2").replace("**", "^").replace("/s\ufffd", "/s^2")
    )
    unit = _PER.sub(_over, _SECONDS.sub(r"\1s", unit.translate(_RAISED)))
    unit = _SQUARED.sub("/s^2", unit)
    if unit.startswith("(") and unit.endswith(")"):
        unit = unit[1:-1].strip()
    unit = _without_lost_brackets(unit)
    if unit.upper() in {"", "NONE", "-"}:
        return ""
    return _ALIASES.get(unit, unit)


def _without_lost_brackets(unit: str) -> str:
    """A unit cut off by a field's end or written with one bracket only, as "1/N)*(m/s^2" for (1/N)*(m/s^2)."""
    if unit.count("(") == unit.count(")") and not unit.startswith("1/N)"):
        return unit
    turned = re.fullmatch(r"\(?1/N\)?\*\(?(.+?)\)?", unit)
    if turned:
        return f"{turned[1]}/N"
    return unit.strip("()") if unit.count("(") + unit.count(")") == 1 else unit


def quantity_of(unit: str) -> Quantity | None:
    """What a unit measures; None if it is not known."""
    return next((quantity for quantity, units in TO_SI.items() if unit in units), None)


def frf_unit(numerator: str, denominator: str) -> tuple[FrfQuantity, float] | None:
    """Quantity and factor to SI of an FRF; None if the units are not those of one.

    Args:
        numerator: unit of the response, or of the whole FRF, as in "m/s^2/N".
        denominator: unit of the force, "" if the numerator's text holds both.
    """
    if not denominator and numerator in _WHOLE_FRF:
        return _WHOLE_FRF[numerator], 1.0
    if not denominator:
        left, _, right = numerator.rpartition("/")
        numerator, denominator = normal_unit(left), normal_unit(right)
    response = quantity_of(numerator)
    if response not in _FRF_OF or denominator not in TO_SI["force"]:
        return None
    return _FRF_OF[response], TO_SI[response][numerator] / TO_SI["force"][denominator]


def to_seconds(unit: str, where: str = "") -> float:
    """What turns times in a unit into seconds; without a unit they are in s.

    Raises:
        DataError: it is no unit of time.
    """
    return _factor(unit, _TIMES, "time", "s, ms, us, ns, min, h or d", where)


def to_hertz(unit: str, where: str = "") -> float:
    """What turns frequencies in a unit into Hz; without a unit they are in Hz.

    Raises:
        DataError: it is no unit of frequency.
    """
    return _factor(unit, _FREQUENCIES, "frequency", "Hz, kHz, rad/s or cpm", where)


def is_of_time(unit: str) -> bool:
    """Whether a unit, which must be there, is one of time."""
    return bool(unit) and normal_unit(unit).lower() in _TIMES


def is_of_frequency(unit: str) -> bool:
    """Whether a unit, which must be there, is one of frequency."""
    return bool(unit) and normal_unit(unit).lower() in _FREQUENCIES


def is_unit(unit: str) -> bool:
    """Whether a normal unit is one of a channel, of an FRF or its part, or of an abscissa."""
    of_axis = is_of_time(unit) or is_of_frequency(unit) or unit in _OF_PARTS
    return bool(unit) and bool(of_axis or quantity_of(unit) or frf_unit(unit, ""))


def name_and_unit(heading: str) -> tuple[str, str]:
    """Name and unit of a heading: `force [N]`, `force (N)`, `force in N`, or `force/N` as ISO 80000 has it."""
    place = _last_bracket(heading.strip())
    if place is not None and not _NUMBER.fullmatch(heading.strip()[place + 1 : -1]):
        return heading.strip()[:place].rstrip("/ "), normal_unit(heading.strip()[place + 1 : -1])
    name, _, unit = (part.strip() for part in heading.partition("/"))
    if name and is_unit(normal_unit(unit)) and not is_unit(name.split()[-1]):
        return name, normal_unit(unit)
    if (spoken := _IN_UNIT.match(heading.strip())) and is_unit(normal_unit(spoken["unit"])):
        return spoken["name"] or heading.strip(), normal_unit(spoken["unit"])
    return heading.strip(), ""


def unit_in_name(name: str) -> str:
    """The unit with which the name of a channel or an array ends, if it is a known one; else ""."""
    unit = name_and_unit(name)[1]
    return unit if is_unit(unit) else ""


def without_unit(name: str) -> str:
    """The name of a channel or an array without the known unit with which it may end."""
    return name_and_unit(name)[0] if unit_in_name(name) else name


def _last_bracket(heading: str) -> int | None:
    """Where the bracket opens that closes at the end; None if none does."""
    depth = 0
    for place in range(len(heading) - 1, -1, -1):
        depth += (heading[place] in ")]") - (heading[place] in "([")
        if depth == 0:
            return place if heading[place] in "([" else None
    return None


def _factor(unit: str, known: dict[str, float], what: str, allowed: str, where: str) -> float:
    factor = known.get(normal_unit(unit).lower())
    if factor is None:
        raise DataError(f"unit {unit!r} is no unit of {what}", where=where, remedy=f"use {allowed}")
    return factor
