"""Attributes by name: what number and type each has is read from the vendor's own description of the wire."""

import re
from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as messages

_ENUM = re.compile(
    r"(?P<family>\w+?)(?P<kind>Int32Array|UInt32Array|DoubleArray|Int32|UInt32|UInt64|Double|Bool|String|Bytes|"
    r"Timestamp)Attribute"
)
_DESCRIPTOR: Any = messages.DESCRIPTOR

FAMILIES = {
    "SystemInfo": "System", "Chan": "Channel", "PhysicalChan": "PhysicalChannel", "Trig": "Trigger",
    "TimingEx": "Timing", "CalInfo": "CalibrationInfo", "ExportedSignal": "ExportSignal",
    "PersistedChan": "PersistedChannel",
}  # fmt: skip
"""Family of attributes by its short form in a call's name, where the two differ."""


def _read() -> dict[str, dict[int, tuple[str, str]]]:
    found: dict[str, dict[int, tuple[str, str]]] = {}
    for title, enum in _DESCRIPTOR.enum_types_by_name.items():
        match = _ENUM.fullmatch(title)
        if match is None:
            continue
        known = found.setdefault(match["family"], {})
        for value in enum.values:
            if value.number:
                known[value.number] = (value.name.partition("_ATTRIBUTE_")[2], match["kind"])
    return found


_NAMES = _read()
_UNLISTED = {0x31E8: ("DEFAULT_NUMBER_OF_SAMPLES_TO_READ", "UInt32")}
ZEROS: dict[str, Any] = {
    "Int32": 0, "UInt32": 0, "UInt64": 0, "Double": 0.0, "Bool": False, "String": "", "Bytes": b"", "Int32Array": [],
    "UInt32Array": [], "DoubleArray": [],
}  # fmt: skip


def lookup(family: str, number: int) -> tuple[str, str]:
    """Name and type of an attribute; an unknown one has the name ""."""
    return _NAMES.get(family, {}).get(number, _UNLISTED.get(number, ("", "Int32")))


def kind_of(family: str, name: str) -> str:
    """Type of an attribute by its name; "" if there is none."""
    return next((kind for found, kind in _NAMES.get(family, {}).values() if found == name), "")
