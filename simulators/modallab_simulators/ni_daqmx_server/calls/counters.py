"""Counter channels that measure and that generate."""

from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.analog_inputs import as_kind
from modallab_simulators.ni_daqmx_server.calls.channel_names import assigned, split
from modallab_simulators.ni_daqmx_server.calls.kinds import MEASURES, settings
from modallab_simulators.ni_daqmx_server.counter_task import TICKS_HZ, CounterInputTask, CounterOutputTask
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.tasks import Channel

Answer = dict[str, Any]
OUTPUT_TYPES = {"PulseFreq": 10119, "PulseTime": 10269, "PulseTicks": 10268}


def _module(system: SimulatedSystem, counter: str) -> Module:
    name, _, rest = counter.partition("/")
    if name in system.chassis and rest.startswith("_ctr"):
        # A chassis has counters of its own, which are named by an underscore.
        return next(m for m in system.modules.values() if m.chassis == name)
    module = system.module_of(counter)
    if counter not in module.counter_names() and not rest.startswith("_"):
        raise StatusError(status.NO_SUCH_CHANNEL, f"Physical Channel Specified: {counter}")
    return module


def add_measuring(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Counters that measure."""
    task: CounterInputTask = as_kind(system, request.task.name, CounterInputTask)
    task.kind, task.pulses = kind, system.pulses
    physical = split(str(request.counter))
    for name, place in zip(assigned(str(request.name_to_assign_to_channel), physical), physical, strict=True):
        task.channels.append(Channel(name, place, _module(system, place)))
        task.resources.add(place)
        for attribute, value in settings(kind, "CI", request).items():
            task.attributes[name, attribute] = value
        task.attributes[name, "CI_MEAS_TYPE"] = MEASURES[kind][0]
    return {}


def add_generating(system: SimulatedSystem, request: Any, kind: str) -> Answer:
    """Counters that give out pulses."""
    task: CounterOutputTask = as_kind(system, request.task.name, CounterOutputTask)
    physical = split(str(request.counter))
    for name, place in zip(assigned(str(request.name_to_assign_to_channel), physical), physical, strict=True):
        channel = Channel(name, place, _module(system, place))
        task.channels.append(channel)
        task.resources.add(place)
        for attribute, value in settings(f"CO{kind}", "CO", request).items():
            task.attributes[name, attribute] = value
        task.attributes[name, "CO_OUTPUT_TYPE"] = OUTPUT_TYPES[kind]
        task.trains[name] = _train(request, kind)
    return {}


def _train(request: Any, kind: str) -> tuple[float, float]:
    if kind == "PulseFreq":
        return request.freq, request.duty_cycle
    high, low = (
        (request.high_time, request.low_time)
        if kind == "PulseTime"
        else (request.high_ticks / TICKS_HZ, request.low_ticks / TICKS_HZ)
    )
    return train(high, low)


def train(high_s: float, low_s: float) -> tuple[float, float]:
    """Frequency and duty cycle of pulses by their times."""
    return 1 / (high_s + low_s), high_s / (high_s + low_s)
