"""Channels of an input task: IEPE, bridge or plain voltage, and what their sensors say of themselves (IEEE 1451.4)."""

from collections.abc import Sequence
from typing import Any

import grpc
import nidaqmx.errors
from nidaqmx.constants import (
    AccelSensitivityUnits,
    AccelUnits,
    Coupling,
    ExcitationSource,
    ForceIEPESensorSensitivityUnits,
    ForceUnits,
)

from modallab.core.errors import ConfigurationError
from modallab.core.units import STANDARD_GRAVITY, Test, si_factor
from modallab_drivers.ni_daqmx.errors import typed_error, typed_errors
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route

BRIDGE_V = 5.0


def add_channel(task: Any, plug: Plug, test: Test, where: str) -> float:
    """Add one input to a task as the rig couples it; returns its volts per unit as delivered.

    Raises:
        ConfigurationError: the coupling or the input cannot be had.
    """
    channel, where = plug.channel, f"{where}, channels[{plug.channel.index}].input ({plug.channel.name})"
    # In volts per the SI unit; its sign, for a turned sensor, is the rig's matter.
    volts = abs(channel.sensitivity(test)) / si_factor(channel.quantity, channel.unit, where)
    with typed_errors(where):
        if channel.coupling == "IEPE" and channel.quantity == "acceleration":
            _add_iepe(task, plug, volts)
        elif channel.coupling == "IEPE" and channel.quantity == "force":
            _add_force(task, plug, volts)
        elif channel.coupling == "IEPE":
            _add_fed_voltage(task, plug)
            return 1.0
        elif channel.coupling == "bridge" and channel.quantity == "acceleration":
            _add_bridge(task, plug, volts)
        elif channel.coupling in ("DC", "AC"):
            _add_voltage(task, plug)
            return 1.0
        else:
            raise ConfigurationError(
                f"coupling {channel.coupling} is not possible for a channel of {channel.quantity}",
                where=where,
                remedy="use DC or AC with a preamplifier, IEPE for a sensor with supply, bridge for acceleration",
            )
    return volts


def _add_voltage(task: Any, plug: Plug) -> None:
    added = task.ai_channels.add_ai_voltage_chan(plug.physical, min_val=-plug.range_v, max_val=plug.range_v)
    if plug.channel.coupling == "AC":
        added.ai_coupling = Coupling.AC


def _add_iepe(task: Any, plug: Plug, volts: float) -> None:
    most = plug.range_v / volts
    added = task.ai_channels.add_ai_accel_chan(
        plug.physical,
        min_val=-most,
        max_val=most,
        units=AccelUnits.METERS_PER_SECOND_SQUARED,
        sensitivity=1e3 * volts * STANDARD_GRAVITY,
        sensitivity_units=AccelSensitivityUnits.MILLIVOLTS_PER_G,
        current_excit_source=ExcitationSource.INTERNAL,
        current_excit_val=plug.supply_a,
    )
    _without_bias(added)


def _add_force(task: Any, plug: Plug, volts: float) -> None:
    most = plug.range_v / volts
    added = task.ai_channels.add_ai_force_iepe_chan(
        plug.physical,
        units=ForceUnits.NEWTONS,
        min_val=-most,
        max_val=most,
        sensitivity=1e3 * volts,
        sensitivity_units=ForceIEPESensorSensitivityUnits.MILLIVOLTS_PER_NEWTON,
        current_excit_source=ExcitationSource.INTERNAL,
        current_excit_val=plug.supply_a,
    )
    _without_bias(added)


def _add_fed_voltage(task: Any, plug: Plug) -> None:
    # The package has no IEPE channel for velocity or displacement.
    added = task.ai_channels.add_ai_voltage_chan(plug.physical, min_val=-plug.range_v, max_val=plug.range_v)
    added.ai_excit_src = ExcitationSource.INTERNAL
    added.ai_excit_val = plug.supply_a
    _without_bias(added)


def _without_bias(added: Any) -> None:
    # A device may have DC as its default, and would then read the sensor's bias of some 10 V.
    added.ai_coupling = Coupling.AC


def _add_bridge(task: Any, plug: Plug, volts: float) -> None:
    most = plug.range_v / volts
    task.ai_channels.add_ai_accel_4_wire_dc_voltage_chan(
        plug.physical,
        min_val=-most,
        max_val=most,
        units=AccelUnits.METERS_PER_SECOND_SQUARED,
        sensitivity=1e3 * volts * STANDARD_GRAVITY,
        sensitivity_units=AccelSensitivityUnits.MILLIVOLTS_PER_G,
        voltage_excit_source=ExcitationSource.INTERNAL,
        voltage_excit_val=plug.channel.excitation_v or BRIDGE_V,
        use_excit_for_scaling=False,
    )


NEWTONS_PER_POUND = 4.4482216152605


def teds_sensitivities(route: Route, plugs: Sequence[Plug]) -> dict[str, float]:
    """V per SI unit of every IEPE accelerometer and force transducer that says so, by channel name."""
    found = {plug.channel.name: _sensitivity(route, plug) for plug in _with_teds(plugs)}
    return {name: value for name, value in found.items() if value is not None}


def teds_serials(route: Route, plugs: Sequence[Plug]) -> dict[str, str]:
    """Serial number of every IEPE sensor that says so, by channel name."""
    found: dict[str, str] = {}
    for plug in _with_teds(plugs):
        try:
            number = int(route.physical_channel(plug.physical).teds_serial_num)
        except nidaqmx.errors.Error as error:
            _require_answer(error, route)
            continue
        if number:
            found[plug.channel.name] = str(number)
    return found


def _with_teds(plugs: Sequence[Plug]) -> list[Plug]:
    return [p for p in plugs if p.channel.coupling == "IEPE" and p.channel.quantity in ("acceleration", "force")]


def _sensitivity(route: Route, plug: Plug) -> float | None:
    with typed_errors(route.address.url):
        task: Any = route.task()
    try:
        return _of_force(task, plug) if plug.channel.quantity == "force" else _of_acceleration(task, plug)
    except nidaqmx.errors.Error as error:
        _require_answer(error, route)
        return None
    finally:
        task.close()


def _require_answer(error: nidaqmx.errors.Error, route: Route) -> None:
    # No data sheet, or a server too old for the question, is an answer; a device that is gone gives none.
    unknown = isinstance(error, nidaqmx.errors.RpcError) and error.rpc_code == grpc.StatusCode.UNIMPLEMENTED
    if not (isinstance(error, nidaqmx.errors.DaqError) or unknown):
        raise typed_error(error, route.address.url) from error


def _of_acceleration(task: Any, plug: Plug) -> float:
    added = task.ai_channels.add_teds_ai_accel_chan(plug.physical)
    milli = added.ai_accel_sensitivity_units == AccelSensitivityUnits.MILLIVOLTS_PER_G
    return float(added.ai_accel_sensitivity) * (1e-3 if milli else 1.0) / STANDARD_GRAVITY


def _of_force(task: Any, plug: Plug) -> float:
    added = task.ai_channels.add_teds_ai_force_iepe_chan(plug.physical)
    units = added.ai_force_iepe_sensor_sensitivity_units
    per_pound = units == ForceIEPESensorSensitivityUnits.MILLIVOLTS_PER_POUND
    return 1e-3 * float(added.ai_force_iepe_sensor_sensitivity) / (NEWTONS_PER_POUND if per_pound else 1.0)
