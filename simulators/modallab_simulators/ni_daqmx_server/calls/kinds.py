"""Kinds of channels: what a call that makes one measures, and which attribute each of its fields sets."""

import re
from typing import Any

from modallab_simulators.ni_daqmx_server.status import StatusError, kind_of

_RANGE = re.compile(r"(?P<stem>.*?)(?P<first>\d+):(?:.*?)(?P<last>\d+)")
BAD_RANGE = -200498


def split_channel_list(names: str) -> list[str]:
    """Each channel of a list by itself.

    Raises:
        StatusError: a range that cannot be read.
    """
    found: list[str] = []
    for part in (p.strip().removeprefix("/") for p in names.split(",")):
        if ":" not in part:
            found += [part] if part else []
            continue
        match = _RANGE.fullmatch(part)
        if match is None:
            raise StatusError(BAD_RANGE, f"Channels: {part}")
        first, last = int(match["first"]), int(match["last"])
        step = 1 if last >= first else -1
        found += [f"{match['stem']}{n}" for n in range(first, last + step, step)]
    return found


def channel_names(wanted: str, physical: list[str]) -> list[str]:
    """The task's names of physical channels: those that were asked for, or their own."""
    if not wanted:
        return physical
    names = split_channel_list(wanted)
    if len(names) == len(physical):
        return names
    return [f"{wanted}{n}" for n in range(len(physical))]


MEASURES: dict[str, tuple[int, str]] = {
    "Voltage": (10322, "AI_VOLTAGE_UNITS"), "VoltageRMS": (10350, "AI_VOLTAGE_ACRMS_UNITS"),
    "VoltageWithExcit": (10323, "AI_VOLTAGE_UNITS"), "Current": (10134, "AI_CURRENT_UNITS"),
    "CurrentRMS": (10351, "AI_CURRENT_ACRMS_UNITS"), "Bridge": (15908, "AI_BRIDGE_UNITS"),
    "FreqVoltage": (10181, "AI_FREQ_UNITS"), "Resistance": (10278, "AI_RESISTANCE_UNITS"),
    "Thrmcpl": (10303, "AI_TEMP_UNITS"), "ThrmstrIex": (10302, "AI_TEMP_UNITS"),
    "ThrmstrVex": (10302, "AI_TEMP_UNITS"), "RTD": (10301, "AI_TEMP_UNITS"),
    "TempBuiltInSensor": (10311, "AI_TEMP_UNITS"), "StrainGage": (10300, "AI_STRAIN_UNITS"),
    "RosetteStrainGage": (15980, "AI_STRAIN_UNITS"), "PosLVDT": (10352, "AI_LVDT_UNITS"),
    "PosRVDT": (10353, "AI_RVDT_UNITS"), "PosEddyCurrProxProbe": (14835, "AI_EDDY_CURRENT_PROX_PROBE_UNITS"),
    "Accel": (10356, "AI_ACCEL_UNITS"), "AccelCharge": (16104, "AI_ACCEL_UNITS"),
    "Accel4WireDCVoltage": (16106, "AI_ACCEL_UNITS"), "VelocityIEPE": (15966, "AI_VELOCITY_UNITS"),
    "ForceBridge": (15899, "AI_FORCE_UNITS"), "ForceIEPE": (15895, "AI_FORCE_UNITS"),
    "PressureBridge": (15902, "AI_PRESSURE_UNITS"), "Microphone": (10354, "AI_SOUND_PRESSURE_UNITS"),
    "TorqueBridge": (15905, "AI_TORQUE_UNITS"), "Charge": (16105, "AI_CHARGE_UNITS"), "Power": (16201, ""),
    "CalculatedPower": (16204, "AI_POWER_UNITS"),
    "AngEncoder": (10360, "CI_ANG_ENCODER_UNITS"), "LinEncoder": (10361, "CI_LIN_ENCODER_UNITS"),
    "AngVelocity": (16078, "CI_VELOCITY_ANG_ENCODER_UNITS"), "LinVelocity": (16079, "CI_VELOCITY_LIN_ENCODER_UNITS"),
    "CountEdges": (10125, ""), "DutyCycle": (16070, ""), "Freq": (10179, "CI_FREQ_UNITS"),
    "Period": (10256, "CI_PERIOD_UNITS"), "PulseWidth": (10359, "CI_PULSE_WIDTH_UNITS"),
    "SemiPeriod": (10289, "CI_SEMI_PERIOD_UNITS"), "PulseFreq": (15864, "CI_PULSE_FREQ_UNITS"),
    "PulseTime": (15865, "CI_PULSE_TIME_UNITS"), "PulseTicks": (15866, ""),
    "TwoEdgeSep": (10267, "CI_TWO_EDGE_SEP_UNITS"), "GPSTimestamp": (10362, "CI_TIMESTAMP_UNITS"),
}  # fmt: skip
"""Type of measurement and the attribute of its units, by kind of channel."""

_SENSITIVITY = {
    "Accel": "AI_ACCEL_", "AccelCharge": "AI_ACCEL_CHARGE_", "Accel4WireDCVoltage": "AI_ACCEL_4_WIRE_DC_VOLTAGE_",
    "ForceIEPE": "AI_FORCE_IEPE_SENSOR_", "VelocityIEPE": "AI_VELOCITY_IEPE_SENSOR_", "PosLVDT": "AI_LVDT_",
    "PosRVDT": "AI_RVDT_", "PosEddyCurrProxProbe": "AI_EDDY_CURRENT_PROX_PROBE_",
}  # fmt: skip

_STARTING = {"Freq": "CI_FREQ_STARTING_EDGE", "Period": "CI_PERIOD_STARTING_EDGE", "CountEdges":
             "CI_COUNT_EDGES_ACTIVE_EDGE", "DutyCycle": "CI_DUTY_CYCLE_STARTING_EDGE"}  # fmt: skip

_FIELDS = {
    "terminal_config": "AI_TERM_CFG", "voltage_excit_source": "AI_EXCIT_SRC", "voltage_excit_val": "AI_EXCIT_VAL",
    "current_excit_source": "AI_EXCIT_SRC", "current_excit_val": "AI_EXCIT_VAL",
    "use_excit_for_scaling": "AI_EXCIT_USE_FOR_SCALING", "bridge_config": "AI_BRIDGE_CFG",
    "nominal_bridge_resistance": "AI_BRIDGE_NOM_RESISTANCE", "shunt_resistor_loc": "AI_CURRENT_SHUNT_LOC",
    "ext_shunt_resistor_val": "AI_CURRENT_SHUNT_RESISTANCE", "forward_coeffs": "AI_BRIDGE_POLY_FORWARD_COEFF",
    "reverse_coeffs": "AI_BRIDGE_POLY_REVERSE_COEFF", "electrical_units": "AI_BRIDGE_ELECTRICAL_UNITS",
    "physical_units": "AI_BRIDGE_PHYSICAL_UNITS", "electrical_vals": "AI_BRIDGE_TABLE_ELECTRICAL_VALS",
    "physical_vals": "AI_BRIDGE_TABLE_PHYSICAL_VALS",
    "first_electrical_val": "AI_BRIDGE_TWO_POINT_LIN_FIRST_ELECTRICAL_VAL",
    "second_electrical_val": "AI_BRIDGE_TWO_POINT_LIN_SECOND_ELECTRICAL_VAL",
    "first_physical_val": "AI_BRIDGE_TWO_POINT_LIN_FIRST_PHYSICAL_VAL",
    "second_physical_val": "AI_BRIDGE_TWO_POINT_LIN_SECOND_PHYSICAL_VAL", "threshold_level": "AI_FREQ_THRESH_VOLTAGE",
    "hysteresis": "AI_FREQ_HYST", "mic_sensitivity": "AI_MICROPHONE_SENSITIVITY",
    "max_snd_press_level": "AI_SOUND_PRESSURE_MAX_SOUND_PRESSURE_LVL", "voltage_excit_freq": "AI_AC_EXCIT_FREQ",
    "ac_excit_wire_mode": "AI_AC_EXCIT_WIRE_MODE", "voltage_setpoint": "PWR_VOLTAGE_SETPOINT",
    "current_setpoint": "PWR_CURRENT_SETPOINT", "output_enable": "PWR_OUTPUT_ENABLE", "rtd_type": "AI_RTD_TYPE",
    "resistance_config": "AI_RESISTANCE_CFG", "r0": "AI_RTD_R0", "r1": "AI_THRMSTR_R1", "a": "AI_THRMSTR_A",
    "b": "AI_THRMSTR_B", "c": "AI_THRMSTR_C", "rosette_type": "AI_ROSETTE_STRAIN_GAGE_ROSETTE_TYPE",
    "gage_orientation": "AI_ROSETTE_STRAIN_GAGE_ORIENTATION", "strain_config": "AI_STRAIN_GAGE_CFG",
    "gage_factor": "AI_STRAIN_GAGE_GAGE_FACTOR", "nominal_gage_resistance": "AI_BRIDGE_NOM_RESISTANCE",
    "poisson_ratio": "AI_STRAIN_GAGE_POISSON_RATIO", "lead_wire_resistance": "AI_LEAD_WIRE_RESISTANCE",
    "initial_bridge_voltage": "AI_BRIDGE_INITIAL_VOLTAGE", "thermocouple_type": "AI_THRMCPL_TYPE",
    "cjc_source": "AI_THRMCPL_CJC_SRC", "cjc_val": "AI_THRMCPL_CJC_VAL", "cjc_channel": "AI_THRMCPL_CJC_CHAN",
    "voltage_min_val": "AI_CALCULATED_POWER_VOLTAGE_MIN", "voltage_max_val": "AI_CALCULATED_POWER_VOLTAGE_MAX",
    "current_min_val": "AI_CALCULATED_POWER_CURRENT_MIN", "current_max_val": "AI_CALCULATED_POWER_CURRENT_MAX",
    "initial_count": "CI_COUNT_EDGES_INITIAL_CNT", "count_direction": "CI_COUNT_EDGES_DIR",
    "zidx_enable": "CI_ENCODER_Z_INDEX_ENABLE", "zidx_val": "CI_ENCODER_Z_INDEX_VAL",
    "zidx_phase": "CI_ENCODER_Z_INDEX_PHASE", "initial_angle": "CI_ANG_ENCODER_INITIAL_ANGLE",
    "initial_pos": "CI_LIN_ENCODER_INITIAL_POS", "sync_method": "CI_GPS_SYNC_METHOD",
    "first_edge": "CI_TWO_EDGE_SEP_FIRST_EDGE", "second_edge": "CI_TWO_EDGE_SEP_SECOND_EDGE",
    "min_freq": "CI_MIN", "max_freq": "CI_MAX", "idle_state": "CO_PULSE_IDLE_STATE", "freq": "CO_PULSE_FREQ",
    "duty_cycle": "CO_PULSE_DUTY_CYC", "low_time": "CO_PULSE_LOW_TIME", "high_time": "CO_PULSE_HIGH_TIME",
    "low_ticks": "CO_PULSE_LOW_TICKS", "high_ticks": "CO_PULSE_HIGH_TICKS",
}  # fmt: skip

_BY_KIND = {
    ("AngEncoder", "decoding_type"): "CI_ENCODER_DECODING_TYPE", ("LinEncoder", "decoding_type"):
    "CI_ENCODER_DECODING_TYPE", ("AngVelocity", "decoding_type"): "CI_VELOCITY_ENCODER_DECODING_TYPE",
    ("LinVelocity", "decoding_type"): "CI_VELOCITY_ENCODER_DECODING_TYPE",
    ("AngEncoder", "pulses_per_rev"): "CI_ANG_ENCODER_PULSES_PER_REV",
    ("AngVelocity", "pulses_per_rev"): "CI_VELOCITY_ANG_ENCODER_PULSES_PER_REV",
    ("LinEncoder", "dist_per_pulse"): "CI_LIN_ENCODER_DIST_PER_PULSE",
    ("LinVelocity", "dist_per_pulse"): "CI_VELOCITY_LIN_ENCODER_DIST_PER_PULSE",
    ("Freq", "meas_method"): "CI_FREQ_MEAS_METH", ("Freq", "meas_time"): "CI_FREQ_MEAS_TIME",
    ("Freq", "divisor"): "CI_FREQ_DIV", ("Period", "meas_method"): "CI_PERIOD_MEAS_METH",
    ("Period", "meas_time"): "CI_PERIOD_MEAS_TIME", ("Period", "divisor"): "CI_PERIOD_DIV",
    ("PulseWidth", "starting_edge"): "CI_PULSE_WIDTH_STARTING_EDGE",
    ("PulseTicks", "source_terminal"): "CI_CTR_TIMEBASE_SRC",
    ("COPulseFreq", "initial_delay"): "CO_PULSE_FREQ_INITIAL_DELAY", ("COPulseFreq", "units"): "CO_PULSE_FREQ_UNITS",
    ("COPulseTime", "initial_delay"): "CO_PULSE_TIME_INITIAL_DELAY", ("COPulseTime", "units"): "CO_PULSE_TIME_UNITS",
    ("COPulseTicks", "initial_delay"): "CO_PULSE_TICKS_INITIAL_DELAY",
    ("COPulseTicks", "source_terminal"): "CO_CTR_TIMEBASE_SRC", ("AOVoltage", "units"): "AO_VOLTAGE_UNITS",
    ("AOCurrent", "units"): "AO_CURRENT_UNITS", ("AOFuncGen", "type"): "AO_FUNC_GEN_TYPE",
    ("AOFuncGen", "freq"): "AO_FUNC_GEN_FREQ", ("AOFuncGen", "amplitude"): "AO_FUNC_GEN_AMPLITUDE",
    ("AOFuncGen", "offset"): "AO_FUNC_GEN_OFFSET", ("StrainGage", "strain_config"): "AI_STRAIN_GAGE_CFG",
    ("PulseFreq", "source_terminal"): "CI_CTR_TIMEBASE_SRC",
}  # fmt: skip


def attribute_of(kind: str, family: str, field: str) -> str:
    """The attribute that a field of a call sets, for a kind of channel of `AI`, `AO`, `CI` or `CO`; "" if none."""
    if (kind, field) in _BY_KIND:
        return _BY_KIND[kind, field]
    if field == "units":
        return MEASURES.get(kind, (0, ""))[1]
    if field in ("sensitivity", "sensitivity_units"):
        return _SENSITIVITY.get(kind, "") + field.upper()
    if field == "edge":
        return _STARTING.get(kind, "")
    if field in ("min_val", "max_val", "custom_scale_name"):
        last = {"min_val": "MIN", "max_val": "MAX", "custom_scale_name": "CUSTOM_SCALE_NAME"}[field]
        return f"{family}_{last}"
    return _FIELDS.get(field, "")


def fields_of(request: Any) -> dict[str, Any]:
    """The fields of a request by name; of an enumerated one the number."""
    names = [f.name for f in request.DESCRIPTOR.fields if not f.name.endswith("_raw")]
    return {name: _value(request, name) for name in names if name != "task"}


def _value(request: Any, name: str) -> Any:
    raw = getattr(request, f"{name}_raw", None)
    value = raw or getattr(request, name) if raw is not None else getattr(request, name)
    return list(value) if hasattr(value, "append") else value


def settings(kind: str, family: str, request: Any) -> dict[str, Any]:
    """The attributes that a call sets, by name."""
    found = {attribute_of(kind, family, field): value for field, value in fields_of(request).items()}
    return {name: value for name, value in found.items() if name and kind_of("Channel", name)}
