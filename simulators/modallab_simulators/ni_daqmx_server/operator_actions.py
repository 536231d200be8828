"""What an operator does to the simulated devices: looks at the outputs, and breaks things."""

from typing import Any

import numpy as np

from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.digital_task import LineTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.lines import MEMORY_S
from modallab_simulators.ni_daqmx_server.output_task import OutputTask


def trace(system: SimulatedSystem, over_s: float, rate_hz: float) -> list[float]:
    """What stood on the shaker's line over the last `over_s`, oldest first.

    Raises:
        ValueError: it is not known for so long.
    """
    if over_s > MEMORY_S:
        raise ValueError(f"a line is remembered for {MEMORY_S:g} s, not for {over_s:g} s")
    now = system.clock.now()
    return system.shaker_line.volts(now - np.arange(round(over_s * rate_hz))[::-1] / rate_hz).tolist()


def levels(system: SimulatedSystem, over_s: float = 0.05) -> dict[str, float]:
    """Largest magnitude on every output over the last `over_s`, and the lines' last changes."""
    now = system.clock.now()
    times = np.linspace(now - over_s, now, 500)
    lines = dict(system.lines)
    if system.generator_line is not None:
        lines["generator"] = system.generator_line
    found = {name: float(np.abs(line.volts(times)).max()) for name, line in lines.items()}
    for task in system.tasks.values():
        if isinstance(task, LineTask):
            found |= {f"{name} changes": float(task.changes) for name in task.lines}
    return found


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
        system.faults.arm(faults.ArmedFault(call, code, kind, int(words[0]) if words else 1))
    elif kind == faults.STATUS:
        system.faults.arm(faults.ArmedFault(words[0], int(words[1]), kind, int(words[2]) if len(words) > 2 else 1))
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
