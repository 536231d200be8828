"""How a channel of the rig becomes one of an input task: IEPE, bridge, or plain voltage behind a preamplifier."""

from typing import Any

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
from modallab_drivers.ni_daqmx.errors import typed_errors
from modallab_drivers.ni_daqmx.plugs import Plug

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
                remedy="use DC or AC with a preamplifier, IEPE for a sensor that is fed, bridge for acceleration",
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
