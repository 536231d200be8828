"""Attributes of scales, of calibrations, and of what a system has saved."""

from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import fields_of
from modallab_simulators.ni_daqmx_server.max_config import Section
from modallab_simulators.ni_daqmx_server.scales import numbers
from modallab_simulators.ni_daqmx_server.status import StatusError

_TYPES = {"Linear": 10447, "Map Ranges": 10448, "Polynomial": 10449, "Table": 10450}
_MADE = {"Lin": "Linear", "Map": "Map Ranges", "Polynomial": "Polynomial", "Table": "Table"}
_UNITS = {"Volts": 10348, "Amps": 10342, "Watts": 16203, "Degrees": 10146, "Deg C": 10143}
_KEYS = {
    "LIN_SLOPE": "Lin.Slope", "LIN_Y_INTERCEPT": "Lin.YIntercept", "MAP_SCALED_MAX": "Map.ScaledMax",
    "MAP_SCALED_MIN": "Map.ScaledMin", "MAP_PRE_SCALED_MAX": "Map.PreScaledMax",
    "MAP_PRE_SCALED_MIN": "Map.PreScaledMin", "POLY_FORWARD_COEFF": "Poly.ForwardCoeff",
    "POLY_REVERSE_COEFF": "Poly.ReverseCoeff", "TABLE_SCALED_VALS": "Table.ScaledVals",
    "TABLE_PRE_SCALED_VALS": "Table.PreScaledVals",
}  # fmt: skip
_FIELDS = {
    "slope": "Lin.Slope", "y_intercept": "Lin.YIntercept", "prescaled_min": "Map.PreScaledMin",
    "prescaled_max": "Map.PreScaledMax", "scaled_min": "Map.ScaledMin", "scaled_max": "Map.ScaledMax",
    "forward_coeffs": "Poly.ForwardCoeff", "reverse_coeffs": "Poly.ReverseCoeff",
    "prescaled_vals": "Table.PreScaledVals", "scaled_vals": "Table.ScaledVals",
}  # fmt: skip


def write_scale(scales: dict[str, Section], request: Any, kind: str) -> None:
    """Keep a scale that a session made."""
    given = fields_of(request)
    units = {number: name for name, number in _UNITS.items()}
    section = {"ScaleType": _MADE[kind], "ScaledUnits": given.get("scaled_units", ""),
               "PreScaledUnits": units.get(given.get("pre_scaled_units", 10348), "Volts")}  # fmt: skip
    for field, value in given.items():
        if field in _FIELDS:
            section[_FIELDS[field]] = _text(value)
    scales[given["name"]] = section


def _text(value: Any) -> str:
    return ", ".join(repr(v) for v in value) if isinstance(value, list) else repr(value)


def scale(server: SimulatedSystem, which: str, name: str) -> Any:
    """An attribute of a scale.

    Raises:
        StatusError: there is no such scale, or it is of another type.
    """
    section = _require(server.saved.scales, which, status.NO_SUCH_SCALE)
    if name == "TYPE":
        return _TYPES[section["ScaleType"]]
    if name == "PRE_SCALED_UNITS":
        return int(section.get("set PRE_SCALED_UNITS", _UNITS.get(section["PreScaledUnits"], 10348)))
    if name in ("SCALED_UNITS", "DESCR"):
        return section.get({"SCALED_UNITS": "ScaledUnits", "DESCR": "Descr"}[name], "")
    key = _KEYS[name]
    if key not in section:
        raise StatusError(status.OTHER_SCALE, f"Custom Scale: {which}\nProperty: {name}")
    return numbers(section[key]) if name.endswith(("COEFF", "VALS")) else float(section[key])


def put_scale(server: SimulatedSystem, which: str, name: str, value: Any) -> None:
    """Set an attribute of a scale."""
    section = _require(server.saved.scales, which, status.NO_SUCH_SCALE)
    if name in _KEYS:
        if _KEYS[name] not in section:
            raise StatusError(status.OTHER_SCALE, f"Custom Scale: {which}\nProperty: {name}")
        section[_KEYS[name]] = _text(value)
    elif name == "PRE_SCALED_UNITS":
        section["set PRE_SCALED_UNITS"] = str(value)
    else:
        section[{"SCALED_UNITS": "ScaledUnits", "DESCR": "Descr"}[name]] = str(value)


def saved(server: SimulatedSystem, family: str, which: str, name: str) -> Any:
    """Who made what is saved, and whether it may be edited."""
    tables = {"PersistedTask": server.saved.tasks, "PersistedChannel": server.saved.channels,
              "PersistedScale": server.saved.scales}  # fmt: skip
    missing = {"PersistedTask": status.NO_SUCH_TASK, "PersistedChannel": status.NO_SUCH_GLOBAL_CHANNEL,
               "PersistedScale": status.NO_SUCH_SCALE}  # fmt: skip
    section = _require(tables[family], which, missing[family])
    if name == "AUTHOR":
        return section.get("Author", "")
    return section.get("AllowInteractiveEditing", "True") == "True"


def calibration(server: SimulatedSystem, which: str, name: str) -> Any:
    """An attribute of a device's calibration.

    Raises:
        StatusError: the device does not have it.
    """
    server.require_device(which)
    known: dict[str, Any] = {
        "SELF_CAL_SUPPORTED": True, "SELF_CAL_LAST_TEMP": 0.0, "EXT_CAL_LAST_TEMP": 0.0, "CAL_DEV_TEMP": 0.0,
        "EXT_CAL_RECOMMENDED_INTERVAL": 24, "CAL_USER_DEFINED_INFO_MAX_SIZE": 4,
        "CAL_USER_DEFINED_INFO": server.notes.get(which, ""),
    }  # fmt: skip
    if name not in known:
        raise StatusError(status.ATTRIBUTE_UNKNOWN, f"Property: {name}")
    return known[name]


def _require(table: dict[str, Section], which: str, code: int) -> Section:
    if which not in table:
        raise StatusError(code, f"Name: {which}")
    return table[which]
