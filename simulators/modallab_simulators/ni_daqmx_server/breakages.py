"""What an operator breaks: the faults of the simulated devices."""

from typing import TYPE_CHECKING, Any

from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask

if TYPE_CHECKING:
    from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem


def arm(system: "SimulatedSystem", line: str) -> None:
    """Arm a fault, as an operator types it: `unplugged -201003`, `status ReadAnalogF64 -200279 2`.

    Raises:
        ValueError: the simulated devices cannot have it.
    """
    kind, words = faults.parse(line, faults.DAQ_FAULTS)
    arguments: dict[str, Any] = {
        faults.SAMPLES_LOST: ("ReadAnalogF64", status.NO_LONGER_AVAILABLE),
        faults.TIME_OUT: ("ReadAnalogF64", 0),
        faults.PARTIAL: ("ReadAnalogF64", 0),
        faults.WARNING: ("ReadAnalogF64", 0),
    }
    if kind in arguments:
        call, code = arguments[kind]
        system.faults.arm(faults.Armed(call, code, kind, int(words[0]) if words else 1))
    elif kind == faults.STATUS:
        system.faults.arm(faults.Armed(words[0], int(words[1]), kind, int(words[2]) if len(words) > 2 else 1))
    else:
        _break(system, kind, words)


def _break(system: "SimulatedSystem", kind: str, words: list[str]) -> None:
    inputs = [task for task in system.tasks.values() if isinstance(task, InputTask)]
    if kind == faults.UNPLUGGED:
        code = int(words[0]) if words else status.DEVICE_GONE
        system.reserved.gone = dict.fromkeys([*system.modules, *system.chassis], code)
        for task in [t for t in system.tasks.values() if isinstance(t, OutputTask)]:
            # The samples came through the cable, which no server changes.
            task.starve(system.clock)
    elif kind == faults.PLUGGED:
        # A device that comes back has forgotten its tasks.
        system.reserved.gone = {}
        system.forget(list(system.tasks.values()))
    elif kind == faults.RESERVED:
        system.reserved.hold(words[0], words[1] if len(words) > 1 else "another program")
    elif kind == faults.RELEASED:
        system.reserved.drop(words[0])
    elif kind == faults.INVALID:
        system.forget(inputs)
    elif kind == faults.DEAD_LINE:
        for task in inputs:
            task.dead.add(int(words[0]))
