"""What an operator sees of the outputs, as on an oscilloscope."""

import numpy as np

from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.line_task import LineTask
from modallab_simulators.ni_daqmx_server.lines import MEMORY_S


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
