"""One clock for inputs of several devices: the driver's own way where it has one, else clock, sync pulse and trigger.

A task on several devices is the surest way: the driver then routes clock, sync pulse and start trigger by itself
("channel expansion": C Series modules of one chassis, PXI devices of one family). Where it rejects that, each device
has its own task. All follow one reference clock, or the first one's timebase; the first one's sync pulse resets the
dividers and delta-sigma converters of all, and its start trigger starts all.

Source: NI-DAQmx Device Considerations, "Synchronizing DSA Devices", and NI's examples of it.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import nidaqmx.errors
from nidaqmx.constants import TaskMode

from modallab.bench.capabilities import ReferenceTrigger
from modallab.core.errors import BenchError, ConfigurationError
from modallab.core.hardware import Synchronisation
from modallab.core.units import Test
from modallab_drivers.ni_daqmx.errors import typed_errors
from modallab_drivers.ni_daqmx.input_task import InputTask
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route

REFERENCE_CLOCKS = {"PXIe_Clk100": 100e6, "PXI_Clk10": 10e6}
"""Of the backplanes, with their rates: the better one first."""


@dataclass(frozen=True, eq=False, slots=True)
class SynchronisedTasks:
    """The tasks of all inputs, in words what keeps them together, and the backplane's clock they follow, if any."""

    tasks: tuple[InputTask, ...]
    synchronised_by: str
    reference_clock: str = ""


def session_name(device: str) -> str:
    """Name under which a server knows an input task: what a killed client leaves behind is recognised by it."""
    return f"modallab-inputs-{device}"


def synchronised_tasks(
    route: Route,
    plugs: Sequence[Plug],
    test: Test,
    rate_hz: float,
    reference: ReferenceTrigger | None,
    wanted: Synchronisation,
) -> SynchronisedTasks:
    """The tasks of all plugs, with their clock set, in the way the rig file wants or the first that the devices take.

    Raises:
        ConfigurationError: a channel or the rate can't be had, or the devices can't be synchronised.
    """
    units: dict[str, list[Plug]] = {}
    for plug in plugs:
        units.setdefault(plug.unit, []).append(plug)
    if len(units) == 1:
        return SynchronisedTasks(_one(route, plugs, test, rate_hz, reference), "")
    ways = _ways(wanted)
    rejected: list[str] = []
    for way in ways:
        try:
            if way == "one task":
                return SynchronisedTasks(_one(route, plugs, test, rate_hz, reference), _said(way, units))
            clock = "" if way == "the timebase" else way
            return SynchronisedTasks(_each(route, units, test, rate_hz, reference, way), _said(way, units), clock)
        except ConfigurationError as error:
            rejected.append(f"by {way}: {error.what}")
    raise ConfigurationError(
        f"{', '.join(units)} cannot be synchronised; {'; '.join(rejected)}",
        where=f"{route.address.url}, rig file fields channels[].input and synchronisation",
        remedy="put all channels on one chassis, connect the devices' clocks, or state how they are connected",
    )


def _ways(wanted: Synchronisation) -> list[str]:
    if wanted.method == "one-task":
        return ["one task"]
    if wanted.method == "timebase":
        return ["the timebase"]
    clocks = [wanted.reference_clock] if wanted.reference_clock else list(REFERENCE_CLOCKS)
    if wanted.method == "reference-clock":
        return clocks
    return ["one task", *clocks, "the timebase"]


def _said(way: str, units: Iterable[str]) -> str:
    first, *others = units
    if way == "one task":
        return f"the driver, {first} and {', '.join(others)} in one task"
    return f"{way}, sync pulse and start trigger of {first} for {', '.join(others)}"


def _one(
    route: Route, plugs: Sequence[Plug], test: Test, rate_hz: float, reference: ReferenceTrigger | None
) -> tuple[InputTask, ...]:
    task = InputTask(route, session_name(route.address.device), plugs, test)
    try:
        task.set_clock(rate_hz, reference, 0 if reference is None else reference.channel)
        if len({plug.unit for plug in plugs}) > 1:
            with typed_errors(route.address.url):
                task.task.control(TaskMode.TASK_VERIFY)
    except BaseException:
        task.close()
        raise
    return (task,)


def _each(
    route: Route,
    units: dict[str, list[Plug]],
    test: Test,
    rate_hz: float,
    reference: ReferenceTrigger | None,
    way: str,
) -> tuple[InputTask, ...]:
    if reference is not None:
        raise ConfigurationError(
            "a device can't trigger the tasks of others",
            where=route.address.url,
            remedy="let the program look for the hit: plan field trigger",
        )
    tasks: list[InputTask] = []
    try:
        for unit, plugs in units.items():
            tasks.append(InputTask(route, session_name(unit), plugs, test))
            tasks[-1].set_clock(rate_hz, None)
        with typed_errors(f"{route.address.url}, synchronised by {way}"):
            _bind(tasks, way)
        _require_one_rate(tasks, units)
    except BaseException:
        for task in tasks:
            with suppress(BenchError):
                task.close()
        raise
    return tuple(tasks)


def _bind(made: Sequence[InputTask], way: str) -> None:
    tasks = [one.task for one in made]
    unit = made[0].plugs[0].unit
    leader, *others = tasks
    if way == "the timebase":
        timebase = _terminal(leader.timing, "samp_clk_timebase_term", f"/{unit}/SampleClockTimebase")
        for other in others:
            other.timing.samp_clk_timebase_src = timebase
            other.timing.samp_clk_timebase_rate = leader.timing.samp_clk_timebase_rate
    else:
        for task in tasks:
            task.timing.ref_clk_src = way
            task.timing.ref_clk_rate = REFERENCE_CLOCKS.get(way, 10e6)
    # Converters that convert at the edge of the sample clock have no filter, and nothing to reset.
    if any(any(one.filter_delays_s()) for one in made):
        pulse = _terminal(leader.timing, "sync_pulse_term", f"/{unit}/SyncPulse")
        for other in others:
            other.timing.sync_pulse_src = pulse
        # All converters must have come out of their reset before the start.
        leader.timing.sync_pulse_min_delay_to_start = max(float(o.timing.sync_pulse_sync_time) for o in others)
    for other in others:
        start = _terminal(leader.triggers.start_trigger, "term", f"/{unit}/ai/StartTrigger")
        other.triggers.start_trigger.cfg_dig_edge_start_trig(start)
    for task in tasks:
        task.control(TaskMode.TASK_VERIFY)


def _terminal(owner: Any, attribute: str, usual: str) -> str:
    # Older drivers do not name the terminal, which is called alike on all devices.
    try:
        return str(getattr(owner, attribute)) or usual
    except nidaqmx.errors.DaqError:
        return usual


def _require_one_rate(tasks: Sequence[InputTask], units: Iterable[str]) -> None:
    rates = [float(task.task.timing.samp_clk_rate) for task in tasks]
    if max(rates) - min(rates) > 1e-9 * max(rates):
        listed = ", ".join(f"{unit} {rate:.9g} Hz" for unit, rate in zip(units, rates, strict=True))
        raise ConfigurationError(f"they give different rates: {listed}", remedy="use devices of one family")
