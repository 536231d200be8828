"""What sensors say of themselves: IEEE 1451.4 data sheets, as NI-DAQmx reads them."""

from collections.abc import Sequence
from typing import Any

import nidaqmx.errors
from nidaqmx.constants import AccelSensitivityUnits

from modallab.core.units import STANDARD_GRAVITY
from modallab_drivers.ni_daqmx.errors import translated
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route


def teds_sensitivities(route: Route, plugs: Sequence[Plug]) -> dict[str, float]:
    """V per m/s^2 of every IEPE accelerometer that says so, by channel name; those without a TEDS are left out."""
    found: dict[str, float] = {}
    for plug in plugs:
        if plug.channel.coupling == "IEPE" and plug.channel.quantity == "acceleration":
            value = _sensitivity(route, plug)
            if value is not None:
                found[plug.channel.name] = value
    return found


def _sensitivity(route: Route, plug: Plug) -> float | None:
    with translated(route.address.url):
        task: Any = route.task()
    try:
        added = task.ai_channels.add_teds_ai_accel_chan(plug.physical)
        per_g = float(added.ai_accel_sensitivity)
        milli = added.ai_accel_sensitivity_units == AccelSensitivityUnits.MILLIVOLTS_PER_G
    except nidaqmx.errors.DaqError:
        return None
    finally:
        task.close()
    return per_g * (1e-3 if milli else 1.0) / STANDARD_GRAVITY
