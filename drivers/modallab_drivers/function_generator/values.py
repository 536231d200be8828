"""What a generator answers, as numbers and words, and when it is what was set."""

import re
from math import inf

INFINITE_OHM = 9e36
"""An open end is a number to most: 9.9E+37."""

AMPLITUDE_TOLERANCE = 0.005
FREQUENCY_TOLERANCE = 1e-5
"""Relative; an instrument rounds to its own steps."""

STEP = {"amplitude": 0.001, "frequency": 0.001, "offset": 0.001, "cycles": 0.0, "phase": 0.1}
"""Vpp, Hz, V, cycles and degrees: the coarsest steps of the instruments that are spoken to."""

_WORDS = {
    "1": "ON", "0": "OFF", "SINE": "SIN", "SINUSOID": "SIN", "TRIGGERED": "TRIG", "NCYC": "TRIG", "MANUAL": "MAN",
    "HZ": "INF", "INFINITY": "INF", "HIGHZ": "INF",
}  # fmt: skip
_PREFIX = {"": 1.0, "U": 1e-6, "K": 1e3, "M": 1e6}
_NUMBER = re.compile(r"([-+]?[0-9.]+(?:E[-+]?[0-9]+)?)([UKM]?)(HZ|VPP|V|S)?", re.IGNORECASE)


def pairs(answer: str) -> dict[str, str]:
    """Values by key in an answer such as `C1:OUTP ON,LOAD,HZ` or `C1:BTWV STATE,ON,TIME,1,CARR,WVTP,SINE`.

    A value without a key is the STATE; what follows CARR belongs to the carrier, whose keys are `CARR.AMP` and so on.
    """
    words = answer.partition(" ")[2].split(",")
    if words[0] in ("ON", "OFF"):
        words = ["STATE", *words]
    cut = words.index("CARR") if "CARR" in words else len(words)
    own, carrier = words[:cut], words[cut + 1 :]
    found = dict(zip(own[0::2], own[1::2], strict=False))
    return found | {f"CARR.{key}": value for key, value in zip(carrier[0::2], carrier[1::2], strict=False)}


def number(text: str) -> float:
    """A number with or without its unit; infinite for an open end, however it is called.

    Raises:
        ValueError: it is none.
    """
    if _WORDS.get(text.upper(), text.upper()) == "INF":
        return inf
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is no number")
    prefix = _PREFIX[match[2].upper()]
    if match[2] == "m" or (prefix == 1e6 and not (match[3] or "").upper().startswith("HZ")):
        prefix = 1e-3
    value = float(match[1]) * prefix
    return inf if value >= INFINITE_OHM else value


def agrees(name: str, wanted: float | str, found: str) -> bool:
    """Whether what is read back is what was set, within the stated tolerance of a number.

    Raises:
        ValueError: a number was due, and something else came.
    """
    if name == "load":
        return number(found) == inf
    if isinstance(wanted, str) and name not in STEP:
        return _WORDS.get(wanted.upper(), wanted.upper()) == _WORDS.get(found.upper(), found.upper())
    relative = {"amplitude": AMPLITUDE_TOLERANCE, "frequency": FREQUENCY_TOLERANCE}.get(name, 0.0)
    value = float(wanted)
    return abs(number(found) - value) <= relative * abs(value) + STEP[name] * (1 + 1e-9)
