"""Electronic data sheets: of the bench's sensors, and of files that an operator has assigned to channels."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab.core.units import STANDARD_GRAVITY
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.status import StatusError

if TYPE_CHECKING:
    from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem

MILLIVOLTS_PER_G = 12509
NUMBER_BITS = 40
MILLIVOLTS_PER_NEWTON = 15891
_MEASURED = {"Accel": "acceleration", "ForceIEPE": "force"}


def sheet_of(system: "SimulatedSystem", physical: str, call: str) -> dict[str, Any] | None:
    """What the data sheet of a sensor sets; None: it has none."""
    if physical in system.sheets:
        return {}
    module = system.module_of(physical)
    if module.simulated or physical not in module.input_names() or call not in _MEASURED:
        return None
    channel = system.rig.channels[system.row_of(physical)]
    if channel.quantity != _MEASURED[call] or channel.coupling != "IEPE" or not channel.serial:
        return None
    if call == "ForceIEPE":
        millivolts = 1e3 * channel.sensitivity("impact")
        return {
            "AI_FORCE_IEPE_SENSOR_SENSITIVITY": millivolts,
            "AI_FORCE_IEPE_SENSOR_SENSITIVITY_UNITS": MILLIVOLTS_PER_NEWTON,
        }
    volts_per_g = channel.sensitivity("impact") * STANDARD_GRAVITY
    return {"AI_ACCEL_SENSITIVITY": 1e3 * volts_per_g, "AI_ACCEL_SENSITIVITY_UNITS": MILLIVOLTS_PER_G}


def serial_of(system: "SimulatedSystem", physical: str) -> int:
    """The serial number in the data sheet of the bench's own sensor; 0: it has none."""
    channel = system.rig.channels[system.row_of(physical)]
    return int(channel.serial) if channel.coupling == "IEPE" and channel.serial.isdecimal() else 0


def configure(system: "SimulatedSystem", request: Any) -> dict[str, Any]:
    """Assign a data sheet to a channel.

    Raises:
        StatusError: no sensor has one, or the file does not hold one.
    """
    physical = request.physical_channel
    system.module_of(physical)
    if not request.file_path:
        raise StatusError(status.NO_TEDS, f"Physical Channel: {physical}")
    try:
        system.sheets[physical] = _packed(Path(request.file_path).read_bytes())
    except OSError as error:
        raise StatusError(status.BAD_TEDS, f"File: {request.file_path}") from error
    return {}


def _packed(data: bytes) -> bytes:
    """The sheet of a file: a virtual one has a byte for each bit, and a number of its own before them."""
    bits = np.frombuffer(data, dtype=np.uint8)
    if not len(bits) or bits.max() > 1:
        return data
    return np.packbits(bits[NUMBER_BITS:], bitorder="little").tobytes()


def clear(system: "SimulatedSystem", request: Any) -> dict[str, Any]:
    """Take a data sheet off a channel again."""
    system.sheets.pop(request.physical_channel, None)
    return {}
