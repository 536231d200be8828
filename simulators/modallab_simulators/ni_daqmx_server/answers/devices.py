"""Attributes of the system, its devices and their physical channels."""

from collections.abc import Callable
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import MEASURES
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import C_SERIES, X_SERIES, Chassis
from modallab_simulators.ni_daqmx_server.teds import serial_of

MODES = [10178, 10123]
"""Finite and continuous."""
TRIGGERED = 0b1100
"""Reference and start triggers, as bits."""
ACCESSORY_NUMBERS = {"RM-24999_A": 0x7992}

_SYSTEM: dict[str, Callable[[SimulatedSystem], Any]] = {
    "NIDAQ_MAJOR_VERSION": lambda s: 25,
    "NIDAQ_MINOR_VERSION": lambda s: 0,
    "NIDAQ_UPDATE_VERSION": lambda s: 0,
    "DEV_NAMES": lambda s: ", ".join([*s.chassis, *s.modules]),
    "GLOBAL_CHANS": lambda s: ", ".join([name for name in s.saved.channels if "/" not in name]),
    "SCALES": lambda s: ", ".join(s.saved.scales),
    "TASKS": lambda s: ", ".join(s.saved.tasks),
}


def system(server: SimulatedSystem, name: str) -> Any:
    """An attribute of the whole system."""
    return _answer(_SYSTEM, name, server)


def _both(limits: tuple[float, ...]) -> list[float]:
    return [sign * limit for limit in limits for sign in (-1.0, 1.0)]


def _measured(module: Module) -> list[int]:
    known = [MEASURES[k][0] for k in module.measures if k in MEASURES]
    return list(dict.fromkeys(known or ([10322] if module.inputs else [])))


_DEVICE: dict[str, Callable[[Module], Any]] = {
    "PRODUCT_TYPE": lambda m: m.product,
    "PRODUCT_NUM": lambda m: m.product_number,
    "PRODUCT_CATEGORY": lambda m: m.category,
    "SERIAL_NUM": lambda m: m.serial,
    "BUS_TYPE": lambda m: m.bus,
    "IS_SIMULATED": lambda m: m.simulated,
    "AI_PHYSICAL_CHANS": lambda m: ", ".join(m.input_names()),
    "AO_PHYSICAL_CHANS": lambda m: ", ".join(m.output_names()),
    "DI_LINES": lambda m: ", ".join(m.line_names()),
    "DO_LINES": lambda m: ", ".join(m.line_names()),
    "DI_PORTS": lambda m: ", ".join(m.port_names()),
    "DO_PORTS": lambda m: ", ".join(m.port_names()),
    "CI_PHYSICAL_CHANS": lambda m: ", ".join(m.counter_names()),
    "CO_PHYSICAL_CHANS": lambda m: ", ".join(m.counter_names()),
    "AI_SUPPORTED_MEAS_TYPES": _measured,
    "AI_VOLTAGE_RNGS": lambda m: _both(m.ranges_v()) if m.inputs and not m.bridge else [],
    "AI_BRIDGE_RNGS": lambda m: _both(m.bridge_ranges),
    "AO_VOLTAGE_RNGS": lambda m: [-m.output_range_v, m.output_range_v] if m.outputs else [],
    "AI_MAX_SINGLE_CHAN_RATE": lambda m: m.max_rate_hz,
    "AI_MAX_MULTI_CHAN_RATE": lambda m: m.max_rate_hz,
    "AI_MIN_RATE": lambda m: m.min_rate_hz,
    "AO_MAX_RATE": lambda m: m.max_output_hz,
    "AI_SIMULTANEOUS_SAMPLING_SUPPORTED": lambda m: not m.multiplexed,
    "AI_CURRENT_INT_EXCIT_DISCRETE_VALS": lambda m: list(m.currents_a),
    "AI_COUPLINGS": lambda m: 0b11 if m.iepe else 0b10,
    "AI_TRIG_USAGE": lambda m: TRIGGERED if m.inputs else 0,
    "AO_TRIG_USAGE": lambda m: 0b1000 if m.outputs else 0,
    "AI_SAMP_MODES": lambda m: MODES if m.inputs else [],
    "AO_SAMP_MODES": lambda m: MODES if m.outputs else [],
    "AO_SAMP_CLK_SUPPORTED": lambda m: bool(m.outputs),
    "DIG_TRIG_SUPPORTED": lambda m: True,
    "ANLG_TRIG_SUPPORTED": lambda m: m.delta_sigma or m.category == X_SERIES,
    "TEDS_HWTEDS_SUPPORTED": lambda m: m.iepe,
    "CHASSIS_MODULE_DEV_NAMES": lambda m: "",
    "COMPACT_DAQ_CHASSIS_DEV_NAME": lambda m: m.chassis,
    "COMPACT_DAQ_SLOT_NUM": lambda m: m.slot,
    "PXI_SLOT_NUM": lambda m: m.slot,
    "PXI_CHASSIS_NUM": lambda m: int(m.name[3 : m.name.index("Slot")]) if m.name.startswith("PXI") else 1,
    "CI_MAX_SIZE": lambda m: 32,
    "CO_MAX_SIZE": lambda m: 32,
    "TERMINALS": lambda m: ", ".join(terminals(m)),
    "ACCESSORY_SERIAL_NUMS": lambda m: [0],
}


def terminals(module: Module) -> list[str]:
    """Terminals of a device, in full."""
    own = [f"PFI{n}" for n in range(16)] if module.category != C_SERIES else []
    kinds = [k for k, has in (("ai", module.inputs), ("ao", module.outputs)) if has]
    clocks = [f"{k}/{last}" for k in kinds for last in ("SampleClock", "StartTrigger", "SampleClockTimebase")]
    return [f"/{module.name}/{name}" for name in [*own, *clocks, "20MHzTimebase", "100kHzTimebase", "10MHzRefClock"]]


_CHASSIS: dict[str, Callable[[Chassis, SimulatedSystem], Any]] = {
    "PRODUCT_TYPE": lambda c, s: c.product,
    "PRODUCT_CATEGORY": lambda c, s: c.category,
    "SERIAL_NUM": lambda c, s: c.serial,
    "BUS_TYPE": lambda c, s: c.bus,
    "IS_SIMULATED": lambda c, s: c.simulated,
    "CHASSIS_MODULE_DEV_NAMES": lambda c, s: ", ".join([m.name for m in s.modules.values() if m.chassis == c.name]),
    "TERMINALS": lambda c, s: ", ".join([f"/{c.name}/PFI{n}" for n in range(2)]),
}


def device(server: SimulatedSystem, which: str, name: str, zero: Any) -> Any:
    """An attribute of a device or chassis."""
    server.require_device(which)
    if which in server.chassis:
        # A chassis has no channels of its own.
        return _CHASSIS[name](server.chassis[which], server) if name in _CHASSIS else zero
    if name in ("ACCESSORY_PRODUCT_TYPES", "ACCESSORY_PRODUCT_NUMS"):
        accessory = server.saved.accessories.get(which, "")
        return accessory if name.endswith("TYPES") else [ACCESSORY_NUMBERS.get(accessory, 0)]
    return _answer(_DEVICE, name, server.module_of(which))


_PHYSICAL: dict[str, Callable[[Module], Any]] = {
    "AI_SUPPORTED_MEAS_TYPES": _measured,
    "AI_TERM_CFGS": lambda m: 0b1000 | 0b1 if m.iepe else (0b111 if m.multiplexed else 0b1),
    "AO_TERM_CFGS": lambda m: 0b10,
    "AO_SUPPORTED_OUTPUT_TYPES": lambda m: [10322],
    "DI_CHANGE_DETECT_SUPPORTED": lambda m: True,
    "DI_SAMP_CLK_SUPPORTED": lambda m: True,
    "DO_SAMP_CLK_SUPPORTED": lambda m: True,
    "DI_PORT_WIDTH": lambda m: m.ports[0],
    "DO_PORT_WIDTH": lambda m: m.ports[0],
    "DI_SAMP_MODES": lambda m: MODES,
    "DO_SAMP_MODES": lambda m: MODES,
}


def physical(server: SimulatedSystem, which: str, name: str) -> Any:
    """An attribute of a physical channel.

    Raises:
        StatusError: there is no such channel.
    """
    module = server.module_of(which)
    known = (*module.input_names(), *module.output_names(), *module.line_names(), *module.port_names(),
             *module.counter_names())  # fmt: skip
    if which not in known and not which.partition("/")[2].startswith("_"):
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {which}")
    short = name.removeprefix("PHYSICAL_CHAN_")
    if short.startswith("TEDS"):
        return _sheet(server, which, short)
    return _answer(_PHYSICAL, short, module)


def _sheet(server: SimulatedSystem, which: str, name: str) -> Any:
    if which not in server.sheets and name == "TEDS_SERIAL_NUM" and serial_of(server, which):
        return serial_of(server, which)
    if which not in server.sheets:
        raise StatusError(status.NO_TEDS, f"Physical Channel: {which}")
    data = server.sheets[which]
    number = int.from_bytes(data[:8], "little")
    known = {
        "TEDS_BIT_STREAM": bytes(data),
        # The basic sheet: 14 bits manufacturer, 15 model, 5 letter, 6 version, 24 serial number.
        "TEDS_MFG_ID": number & 0x3FFF,
        "TEDS_MODEL_NUM": number >> 14 & 0x7FFF,
        "TEDS_VERSION_LETTER": chr(ord("A") - 1 + (number >> 29 & 0x1F or 1)),
        "TEDS_VERSION_NUM": number >> 34 & 0x3F,
        "TEDS_SERIAL_NUM": number >> 40 & 0xFFFFFF,
        "TEDS_TEMPLATE_I_DS": [data[8] >> 2 & 0x3F] if len(data) > 8 else [],
    }
    return _answer({key: (lambda _, value=value: value) for key, value in known.items()}, name, None)


def _answer(table: dict[str, Callable[[Any], Any]], name: str, target: Any) -> Any:
    if name not in table:
        raise StatusError(status.ATTRIBUTE_UNKNOWN, f"Property: {name}")
    return table[name](target)
