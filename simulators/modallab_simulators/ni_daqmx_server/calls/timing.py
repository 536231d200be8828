"""Clocks: rate and length, where they come from."""

from typing import Any

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.kinds import split_channel_list
from modallab_simulators.ni_daqmx_server.counter_task import CounterInputTask, CounterOutputTask, LineTask
from modallab_simulators.ni_daqmx_server.max_config import Section
from modallab_simulators.ni_daqmx_server.modules import coerced_rate
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import DIGITAL, PXI, PXIE

Answer = dict[str, Any]

FINITE, CONTINUOUS = 10178, 10123
LEAST_FINITE = 2
NO_TRIGGER = 10230
SAMPLE_CLOCK, ON_DEMAND, IMPLICIT = 10388, 10390, 10451
HANDSHAKE, BURST, CHANGE_DETECTION, PIPELINED = 10389, 12548, 12504, 14668
BACKPLANE_CLOCKS = {"PXI_CLK10": (PXI, PXIE), "PXIE_CLK100": (PXIE,)}
"""What a device must be plugged into to see them."""
NO_CLOCK = "None"
"""What a task is given that follows no clock but its own."""
_SOURCES = ("SAMP_CLK_SRC", "SAMP_CLK_TIMEBASE_SRC", "REF_CLK_SRC", "SYNC_PULSE_SRC", "DIG_EDGE_START_TRIG_SRC",
            "DIG_EDGE_REF_TRIG_SRC")  # fmt: skip
_TERMINALS = ("PFI", "RTSI", "PXI", "CLOCK", "CLK", "TIMEBASE", "TRIGGER", "INTERNAL", "CTR", "APFI", "EVENT",
              "SYNCPULSE", "COMPARATOR", "FREQOUT", "GATE")  # fmt: skip


def require_terminal(system: SimulatedSystem, source: str) -> None:
    """Reject a clock or trigger terminal that no simulated device has.

    Raises:
        StatusError: there is no such terminal.
    """
    last = source.rpartition("/")[2].upper()
    device = source.split("/")[1] if source.startswith("/") else ""
    known = not device or device in system.modules or device in system.chassis
    if source and not (known and any(part in last for part in _TERMINALS)):
        raise StatusError(status.BAD_ROUTE, f"Source Terminal: {source}")


def _pace(task: Task, kind: int, mode: int, count: int) -> None:
    task.timing = "implicit" if kind == IMPLICIT else "clocked"
    task.attributes["", "SAMP_TIMING_TYPE"] = kind
    task.attributes["", "SAMP_QUANT_SAMP_MODE"] = mode
    task.attributes["", "SAMP_QUANT_SAMP_PER_CHAN"] = count


def require_routes(system: SimulatedSystem, task: Task) -> None:
    """Reject clocks and triggers that cannot be routed: a device says so when it is committed, or asked.

    Raises:
        StatusError: there is no such terminal.
    """
    for attribute in _SOURCES:
        source = task.get(attribute, "")
        require_terminal(system, "" if source.endswith(NO_CLOCK) else source)
    _require_backplane(task)
    count = task.get("SAMP_QUANT_SAMP_PER_CHAN", LEAST_FINITE)
    if task.timing == "clocked" and task.get("SAMP_QUANT_SAMP_MODE") == FINITE and count < LEAST_FINITE:
        raise StatusError(status.INVALID_VALUE, f"Property: SampQuant.SampPerChan\nRequested Value: {count}")


def _require_backplane(task: Task) -> None:
    """Reject a clock of a backplane where a channel's device is not plugged into one that has it."""
    source = str(task.get("REF_CLK_SRC") or "")
    buses = BACKPLANE_CLOCKS.get(source.rpartition("/")[2].upper())
    for channel in task.all_channels() if buses else ():
        if buses and channel.module.bus not in buses:
            said = f"Property: RefClk.Src\nSource Device: {channel.module.name}\nSource Terminal: {source}"
            raise StatusError(status.BAD_ROUTE, said)


def verify(system: SimulatedSystem, task: Task) -> None:
    """Look through all that was set, as a device does before it reserves.

    Raises:
        StatusError: something does not fit.
    """
    require_routes(system, task)
    exported = task.get("START_TRIG_OUTPUT_TERM", "")
    if exported and exported.upper() in ("RTSI", "PFI"):
        raise StatusError(status.NO_SUCH_DESTINATION, f"Destination Terminal: {exported}")
    if task.timing == "on-demand" and task.get("START_TRIG_TYPE", NO_TRIGGER) != NO_TRIGGER:
        raise StatusError(status.TRIGGER_ON_DEMAND, f"Task Name: {task.name}")


def set_clock(system: SimulatedSystem, request: Any) -> Answer:
    """Rate and length, by a clock."""
    task = system.task(request.task.name, Task)
    mode = request.sample_mode_raw or request.sample_mode
    _set_rate(task, request.rate, int(request.samps_per_chan) if mode == FINITE else 0)
    _pace(task, SAMPLE_CLOCK, mode, int(request.samps_per_chan))
    if request.source:
        task.attributes["", "SAMP_CLK_SRC"] = request.source
    else:
        task.attributes.pop(("", "SAMP_CLK_SRC"), None)
    task.attributes["", "SAMP_CLK_ACTIVE_EDGE"] = request.active_edge_raw or request.active_edge
    return {}


def _set_rate(task: Task, rate_hz: float, finite: int) -> None:
    if isinstance(task, AcquiringTask):
        task.set_clock(rate_hz, finite, 0)
    elif isinstance(task, OutputTask):
        module = task.channels[0].module
        highest = module.max_output_hz
        if not np.isfinite(rate_hz) or rate_hz <= 0 or rate_hz > highest * (1 + 1e-9):
            raise StatusError(status.INVALID_VALUE, f"Property: SampClk.Rate\nRequested Value: {rate_hz}")
        for output in (task, *task.others):
            output.rate_hz = coerced_rate((module,), 1, rate_hz) if rate_hz <= module.max_rate_hz else rate_hz
            output.finite = bool(finite)
            output.samples = finite
    elif isinstance(task, LineTask):
        task.rate_hz, task.finite = rate_hz, finite
    elif isinstance(task, CounterOutputTask):
        task.finite = finite
    else:
        raise StatusError(status.NO_CHANNELS, f"Task Name: {task.name}")


def set_rate(task: Task, rate_hz: float) -> None:
    """Another rate for a task that has a clock."""
    finite = task.get("SAMP_QUANT_SAMP_PER_CHAN", 0) if task.get("SAMP_QUANT_SAMP_MODE") == FINITE else 0
    _set_rate(task, rate_hz, finite)


def rate_of(task: Task) -> float | None:
    """Rate of a task's clock; None if it has none."""
    if isinstance(task, AcquiringTask | OutputTask | LineTask):
        return task.rate_hz
    return None


def use_saved_timing(task: Task, section: Section) -> None:
    """The clock of a task that was saved."""
    count = int(section.get("SampQuant.SampPerChan", "1000"))
    mode = FINITE if section.get("SampQuant.SampMode") == "Finite Samples" else CONTINUOUS
    if section.get("SampTimingType") == "Sample Clock":
        _set_rate(task, float(section["SampClk.Rate"]), count if mode == FINITE else 0)
        _pace(task, SAMPLE_CLOCK, mode, count)


def set_implicit(system: SimulatedSystem, request: Any) -> Answer:
    """Length only: the signal itself paces the task."""
    task = system.task(request.task.name, Task)
    mode = request.sample_mode_raw or request.sample_mode
    finite = int(request.samps_per_chan) if mode == FINITE else 0
    if isinstance(task, CounterInputTask):
        task.set_clock(task.rate_hz, finite, 0)
    elif isinstance(task, CounterOutputTask):
        task.finite = finite
    else:
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: SampTimingType")
    _pace(task, IMPLICIT, mode, int(request.samps_per_chan))
    return {}


def _require_digital(task: Task) -> None:
    if not all(c.module.category == DIGITAL for c in task.all_channels()):
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: SampTimingType")


def set_handshaking(system: SimulatedSystem, request: Any) -> Answer:
    """Each sample by a handshake."""
    task = system.task(request.task.name, Task)
    _require_digital(task)
    _pace(task, HANDSHAKE, request.sample_mode_raw or request.sample_mode, int(request.samps_per_chan))
    return {}


def set_change_detection(system: SimulatedSystem, request: Any) -> Answer:
    """A sample whenever one of these lines changes."""
    task = system.task(request.task.name, Task)
    _pace(task, CHANGE_DETECTION, request.sample_mode_raw or request.sample_mode, int(request.samps_per_chan))
    task.attributes["", "CHANGE_DETECT_DI_RISING_EDGE_PHYSICAL_CHANS"] = ", ".join(
        split_channel_list(request.rising_edge_chan)
    )
    task.attributes["", "CHANGE_DETECT_DI_FALLING_EDGE_PHYSICAL_CHANS"] = ", ".join(
        split_channel_list(request.falling_edge_chan)
    )
    return {}


def set_pipelined(system: SimulatedSystem, request: Any) -> Answer:
    """By a clock, with the samples in a pipeline."""
    answer = set_clock(system, request)
    system.task(request.task.name, Task).attributes["", "SAMP_TIMING_TYPE"] = PIPELINED
    return answer


def set_burst(system: SimulatedSystem, request: Any) -> Answer:
    """In bursts by a handshake, with a clock that comes or goes with them."""
    task = system.task(request.task.name, Task)
    _require_digital(task)
    mode, count = request.sample_mode_raw or request.sample_mode, int(request.samps_per_chan)
    _set_rate(task, request.sample_clk_rate, count if mode == FINITE else 0)
    _pace(task, BURST, mode, count)
    exported = hasattr(request, "sample_clk_outp_term")
    known = {
        "DIG_LVL_PAUSE_TRIG_WHEN": request.pause_when_raw or request.pause_when,
        "RDY_FOR_XFER_EVENT_LVL_ACTIVE_LVL": request.ready_event_active_level_raw or request.ready_event_active_level,
        "PAUSE_TRIG_TYPE": 10152,
    }
    if exported:
        known["SAMP_CLK_OUTPUT_TERM"] = request.sample_clk_outp_term
        known["SAMP_CLK_PULSE_POLARITY"] = request.sample_clk_pulse_polarity_raw or request.sample_clk_pulse_polarity
    else:
        known["SAMP_CLK_SRC"] = request.sample_clk_src
        known["SAMP_CLK_ACTIVE_EDGE"] = request.sample_clk_active_edge_raw or request.sample_clk_active_edge
    for attribute, value in known.items():
        task.attributes["", attribute] = value
    return {}
