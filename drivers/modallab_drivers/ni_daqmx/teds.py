"""What sensors say of themselves: IEEE 1451.4 data sheets, as NI-DAQmx reads them."""

from collections.abc import Sequence
from typing import Any

import grpc
import nidaqmx.errors
from nidaqmx.constants import AccelSensitivityUnits, ForceIEPESensorSensitivityUnits

from modallab.core.units import STANDARD_GRAVITY
from modallab_drivers.ni_daqmx.errors import typed_error, typed_errors
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route

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
