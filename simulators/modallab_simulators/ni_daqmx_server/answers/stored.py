"""Attributes that are stored: the vendor's defaults, scales, calibrations, and what a system has saved."""

from collections.abc import Callable
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel, Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import fields_of
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.max_config import Section, numbers
from modallab_simulators.ni_daqmx_server.status import ZEROS, StatusError
from modallab_simulators.ni_daqmx_server.systems import X_SERIES
from modallab_simulators.ni_daqmx_server.task_start import kind_of

NONE, RISING, CONTINUOUS = 10230, 10280, 10123
IEPE_KINDS = ("Accel", "ForceIEPE", "Microphone", "VelocityIEPE")
AC, DC = 10045, 10050

_DEFAULTS: dict[tuple[str, str], Any] = {
    ("Read", "RELATIVE_TO"): 10425, ("Read", "OVERWRITE"): 10159, ("Read", "SLEEP_TIME"): 0.001,
    ("Read", "WAIT_MODE"): 12547, ("Read", "LOGGING_MODE"): 10231, ("Read", "LOGGING_TDMS_OPERATION"): 15847,
    ("Read", "LOGGING_FILE_WRITE_SIZE"): 0xFFFFFFFF, ("Read", "AUTO_START"): True,
    ("Write", "RELATIVE_TO"): 10430, ("Write", "SLEEP_TIME"): 0.001, ("Write", "WAIT_MODE"): 12547,
    ("Write", "REGEN_MODE"): 10097, ("Buffer", "OUTPUT_ONBRD_BUF_SIZE"): 8191,
    ("Buffer", "INPUT_ONBRD_BUF_SIZE"): 4095,
    ("Timing", "SAMP_CLK_ACTIVE_EDGE"): RISING, ("Timing", "SAMP_QUANT_SAMP_MODE"): CONTINUOUS,
    ("Timing", "SAMP_QUANT_SAMP_PER_CHAN"): 1000, ("Timing", "REF_CLK_RATE"): 10e6,
    ("Timing", "AI_CONV_ACTIVE_EDGE"): RISING, ("Timing", "SAMP_CLK_TIMEBASE_ACTIVE_EDGE"): RISING,
    ("Timing", "FIRST_SAMP_TIMESTAMP_TIMESCALE"): 16126, ("Timing", "FIRST_SAMP_CLK_TIMESCALE"): 16126,
    ("Trigger", "START_TRIG_TYPE"): NONE, ("Trigger", "REF_TRIG_TYPE"): NONE, ("Trigger", "PAUSE_TRIG_TYPE"): NONE,
    ("Trigger", "ARM_START_TRIG_TYPE"): NONE, ("Trigger", "ADV_TRIG_TYPE"): NONE, ("Trigger", "HSHK_TRIG_TYPE"): NONE,
    ("Trigger", "DIG_EDGE_START_TRIG_EDGE"): RISING, ("Trigger", "DIG_EDGE_REF_TRIG_EDGE"): RISING,
    ("Trigger", "START_TRIG_TIMESCALE"): 16126, ("Trigger", "START_TRIG_TIMESTAMP_TIMESCALE"): 16126,
    ("Trigger", "REF_TRIG_TIMESTAMP_TIMESCALE"): 16126, ("Trigger", "ARM_START_TRIG_TIMESTAMP_TIMESCALE"): 16126,
    ("Trigger", "ARM_START_TRIG_TIMESCALE"): 16126, ("Trigger", "START_TRIG_DELAY_UNITS"): 10364,
    ("Trigger", "TRIGGER_SYNC_TYPE"): NONE, ("Trigger", "REF_TRIG_PRETRIG_SAMPLES"): 2,
    ("Watchdog", "TIMEOUT"): 10.0, ("Watchdog", "DIG_EDGE_WATCHDOG_EXPIR_TRIG_EDGE"): RISING,
    ("Watchdog", "EXPIR_TRIG_TYPE"): NONE,
    ("ExportSignal", "START_TRIG_PULSE_POLARITY"): 10095, ("ExportSignal", "SAMP_CLK_PULSE_POLARITY"): 10095,
    ("ExportSignal", "SAMP_CLK_OUTPUT_BEHAVIOR"): 10265, ("ExportSignal", "CTR_OUT_EVENT_OUTPUT_BEHAVIOR"): 10265,
    ("Channel", "AI_TERM_CFG"): 10106, ("Channel", "AI_MAX"): 5.0, ("Channel", "AI_MIN"): -5.0,
    ("Channel", "AI_EXCIT_SRC"): NONE, ("Channel", "AI_LOSSY_LSB_REMOVAL_COMPRESSED_SAMP_SIZE"): 16,
    ("Channel", "AI_RAW_DATA_COMPRESSION_TYPE"): NONE, ("Channel", "AI_RTD_A"): 0.00381,
    ("Channel", "AI_RTD_B"): -6.02e-7, ("Channel", "AI_RTD_C"): -6.0e-12, ("Channel", "AI_VOLTAGE_UNITS"): 10348,
    ("Channel", "AO_VOLTAGE_UNITS"): 10348, ("Channel", "AI_DATA_XFER_MECH"): 10054,
    ("Channel", "AO_DATA_XFER_MECH"): 10054, ("Channel", "AI_DATA_XFER_REQ_COND"): 10241,
    ("Channel", "AI_RESOLUTION_UNITS"): 10109, ("Channel", "AI_RAW_SAMP_JUSTIFICATION"): 10279,
    ("Channel", "AI_THRMCPL_CJC_SRC"): 10200, ("Channel", "AI_LEAD_WIRE_RESISTANCE"): 0.0,
    ("Channel", "AI_AUTO_ZERO_MODE"): NONE, ("Channel", "AI_FILTER_DELAY_UNITS"): 10364,
    ("Channel", "AO_TERM_CFG"): 10083, ("Channel", "AO_DAC_REF_VAL"): 10.0, ("Channel", "AO_RESOLUTION"): 16.0,
    ("Channel", "AO_IDLE_OUTPUT_BEHAVIOR"): 12526, ("Channel", "PWR_IDLE_OUTPUT_BEHAVIOR"): 12528,
    ("Channel", "PWR_REMOTE_SENSE"): 16095, ("Channel", "DI_TRISTATE"): True,
    ("Channel", "CI_CTR_TIMEBASE_DIG_FLTR_TIMEBASE_SRC"): "100MHzTimebase",
    ("Channel", "CI_CTR_TIMEBASE_SRC"): "100MHzTimebase", ("Channel", "CO_CTR_TIMEBASE_SRC"): "100MHzTimebase",
    ("Channel", "CI_PRESCALER"): 1, ("Channel", "CO_PRESCALER"): 1,
}  # fmt: skip


def _coupling(task: Task, channel: Channel | None) -> int:
    found = next((c for c in task.channels if c is channel), None) if isinstance(task, InputTask) else None
    return AC if found is not None and found.kind in IEPE_KINDS else DC


def _clock_source(task: Task, channel: Channel | None) -> str:
    if task.timing == "on-demand":
        return ""
    return f"/{task.default_device}/{kind_of(task)}/SampleClockTimebase"


def _timebase(task: Task, channel: Channel | None) -> str:
    first = task.all_channels()[0].module
    return f"/{task.default_device}/{first.timebase_hz / 1e6:g}MHzTimebase"


def _division(task: Task, channel: Channel | None) -> int:
    rate_hz = task.rate_hz if isinstance(task, AcquiringTask) else 1000.0
    return round(task.all_channels()[0].module.timebase_hz / rate_hz)


def _convert_division(task: Task, channel: Channel | None) -> int:
    assert isinstance(task, InputTask)
    module = task.channels[0].module
    return round(module.timebase_hz / task.convert_rate_hz())


def _timing_type(task: Task, channel: Channel | None) -> int:
    return {"on-demand": 10390, "clocked": 10388, "implicit": 10451}[task.timing]


_BY_TASK: dict[tuple[str, str], Callable[[Task, Channel | None], Any]] = {
    ("Channel", "AI_COUPLING"): _coupling,
    ("Timing", "SAMP_CLK_SRC"): _clock_source,
    ("Timing", "SAMP_CLK_TIMEBASE_SRC"): _timebase,
    ("Timing", "SAMP_CLK_TIMEBASE_RATE"): lambda task, _: task.all_channels()[0].module.timebase_hz,
    ("Timing", "SAMP_CLK_TIMEBASE_DIV"): _division,
    ("Timing", "AI_CONV_TIMEBASE_DIV"): _convert_division,
    ("Timing", "SAMP_TIMING_TYPE"): _timing_type,
    ("Timing", "SAMP_CLK_RATE"): lambda task, _: 1000.0,
    ("Timing", "AI_CONV_MAX_RATE"): lambda task, _: task.all_channels()[0].module.max_rate_hz,
    ("Timing", "SAMP_CLK_MAX_RATE"): lambda task, _: task.all_channels()[0].module.max_rate_hz,
    ("Timing", "FIRST_SAMP_TIMESTAMP_ENABLE"): lambda task, _: False,
}


def default(family: str, name: str, kind: str, task: Task, channel: Channel | None) -> Any:
    """What an attribute starts with.

    Raises:
        StatusError: a task of this kind does not have it.
    """
    _require_fitting(family, name, task, channel)
    if (family, name) in _BY_TASK:
        return _BY_TASK[family, name](task, channel)
    if family == "Timing" and name == "REF_CLK_SRC":
        return "OnboardClock" if any(c.module.category == X_SERIES for c in task.all_channels()) else ""
    return _DEFAULTS.get((family, name), ZEROS.get(kind))


def _require_fitting(family: str, name: str, task: Task, channel: Channel | None) -> None:
    prefix = name.partition("_")[0]
    of_kind = family == "Channel" and prefix in ("AI", "AO", "CI", "CO", "DI", "DO")
    if of_kind and channel is not None and prefix.lower() != (kind_of(task) or prefix.lower()):
        raise StatusError(status.NOT_SUPPORTED_HERE, f"Property: {name}\nChannel: {channel.name}")
    if family in ("Timing", "Trigger") and not task.all_channels():
        raise StatusError(status.NO_CHANNELS, f"Property: {name}")


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
