"""Attributes that a device works out from its task."""

from collections.abc import Callable
from typing import Any

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel, Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.sessions import devices_of
from modallab_simulators.ni_daqmx_server.calls.timing import rate_of
from modallab_simulators.ni_daqmx_server.counter_task import (
    CounterInputTask,
    CounterOutputTask,
    DigitalInputTask,
    LineTask,
)
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.task_start import kind_of

ComputationResult = Callable[[SimulatedSystem, Any, Any], Any]
_TYPES: dict[type[Task], int] = {
    InputTask: 10100, OutputTask: 10102, DigitalInputTask: 10151, LineTask: 10153, CounterInputTask: 10131,
    CounterOutputTask: 10132,
}  # fmt: skip


def _overload(server: SimulatedSystem, task: Task, channel: Channel | None) -> bool:
    # Asking whether there is an overload clears the flags.
    if not isinstance(task, InputTask):
        return False
    names = [c.name for c in task.channels]
    over = [n for n, flag in zip(names, task.overload, strict=False) if flag]
    task.attributes["", "OVERLOADED_CHANS"] = ", ".join(over)
    task.overload[:] = False
    return bool(over)


def _filter_delay(server: SimulatedSystem, task: Task, channel: Channel | None) -> float:
    if not isinstance(task, InputTask) or channel is None:
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: AI.FilterDelay")
    return channel.module.delay_samples / task.rate_hz


def _convert_rate(server: SimulatedSystem, task: Task, channel: Channel | None) -> float | None:
    if not isinstance(task, InputTask) or not any(m.multiplexed for m in task.modules):
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: AIConv.Rate")
    return None if any(name == "AI_CONV_RATE" for _, name in task.attributes) else task.convert_rate_hz()


def _rate(server: SimulatedSystem, task: Task, channel: Channel | None) -> float:
    found = rate_of(task)
    if found is None:
        raise StatusError(status.NOT_SUPPORTED_HERE, "Property: SampClk.Rate")
    return found


def _range(server: SimulatedSystem, task: Task, channel: Channel | None) -> float | None:
    if not isinstance(task, InputTask) or channel is None:
        return None
    found = next(c for c in task.channels if c.name == channel.name)
    wanted = max(abs(found.low), abs(found.high)) / abs(found.per_volt)
    fitting = [r for r in channel.module.ranges_v() if r >= wanted * (1 - 1e-6)]
    return fitting[0] if fitting else channel.module.input_range_v


def _low(server: SimulatedSystem, task: Task, channel: Channel | None) -> float | None:
    found = _range(server, task, channel)
    return None if found is None else -found


def _lines(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    return len(channel.physical.split(",")) if channel is not None else 0


def _acquired(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    return task.acquired(server.clock) if isinstance(task, AcquiringTask) else 0


def _available(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    return task.acquired(server.clock) - task.position if isinstance(task, AcquiringTask) else 0


def _played(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    if isinstance(task, OutputTask):
        return task.played(server.clock)
    return 0


def _bytes(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    return max((len(c.physical.split(",")) for c in task.all_channels()), default=1)


def _width(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    channels = task.all_channels()
    if isinstance(task, InputTask | OutputTask):
        return len(channels) * (4 if channels and channels[0].module.bits > 16 else 2)
    lines = _bytes(server, task, channel)
    return len(channels) * (1 if lines <= 8 else 2 if lines <= 16 else 4)


def _dead(server: SimulatedSystem, task: Task, channel: Channel | None) -> str:
    return ", ".join(task.channels[n].name for n in sorted(task.dead)) if isinstance(task, InputTask) else ""


def _count(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    if isinstance(task, OutputTask):
        return 1 + len(task.others)
    return len(task.all_channels())


def _buffer(server: SimulatedSystem, task: Task, channel: Channel | None) -> int | None:
    return task.buffer if isinstance(task, AcquiringTask) and task.timing != "on-demand" else None


def _channels_to_read(server: SimulatedSystem, task: Task, channel: Channel | None) -> str:
    return task.get("CHANNELS_TO_READ") or ", ".join(c.name for c in task.all_channels())


def _start_term(server: SimulatedSystem, task: Task, channel: Channel | None) -> str:
    return f"/{task.default_device}/{kind_of(task)}/StartTrigger"


def _clock_term(server: SimulatedSystem, task: Task, channel: Channel | None) -> str:
    return f"/{task.default_device}/{kind_of(task)}/SampleClock"


def _moved(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    return task.position if isinstance(task, AcquiringTask) else 0


def _coerced(sign: float) -> ComputationResult:
    # Boards with an amplifier for several ranges say the range that they have chosen.
    def limit(server: SimulatedSystem, task: Task, channel: Channel | None) -> float | None:
        if not isinstance(task, InputTask) or channel is None or not channel.module.multiplexed:
            return None
        found = next(c for c in task.channels if c.name == channel.name)
        if found.kind != "Voltage" or found.scaled is not None:
            return None
        set_low, set_high = task.get("AI_MIN", found.low, found.name), task.get("AI_MAX", found.high, found.name)
        wanted = max(abs(set_low), abs(set_high))
        fitting = [r for r in channel.module.ranges_v() if r >= wanted * (1 - 1e-6)]
        return sign * fitting[0] if fitting else None

    return limit


def _default_count(server: SimulatedSystem, task: Task, channel: Channel | None) -> int:
    # What a read of all that is there means for this task.
    return task.left(server.clock) if isinstance(task, AcquiringTask) and task.finite else 0xFFFFFFFF


COMPUTED: dict[tuple[str, str], ComputationResult] = {
    ("Task", "NAME"): lambda s, t, c: t.name,
    ("Task", "CHANNELS"): lambda s, t, c: ", ".join(x.name for x in t.all_channels()),
    ("Task", "DEVICES"): lambda s, t, c: ", ".join(devices_of(t)),
    ("Task", "NUM_CHANS"): lambda s, t, c: len(t.all_channels()),
    ("Task", "NUM_DEVICES"): lambda s, t, c: len(devices_of(t)),
    ("Channel", "CHAN_TYPE"): lambda s, t, c: _TYPES[type(t)],
    ("Channel", "PHYSICAL_CHAN_NAME"): lambda s, t, c: c.physical.replace(",", ", ") if c else "",
    ("Channel", "CHAN_IS_GLOBAL"): lambda s, t, c: bool(t.get("GLOBAL")),
    ("Channel", "AI_MAX"): _coerced(1.0),
    ("Channel", "AI_MIN"): _coerced(-1.0),
    ("Read", "DEFAULT_NUMBER_OF_SAMPLES_TO_READ"): _default_count,
    ("Channel", "AI_RNG_HIGH"): _range,
    ("Channel", "AI_RNG_LOW"): _low,
    ("Channel", "AI_FILTER_DELAY"): _filter_delay,
    ("Channel", "AI_RAW_SAMP_SIZE"): lambda s, t, c: 32 if c and c.module.bits > 16 else 16,
    ("Channel", "AI_RESOLUTION"): lambda s, t, c: float(c.module.bits) if c else 16.0,
    ("Channel", "AI_EXCIT_ACTUAL_VAL"): lambda s, t, c: t.get("AI_EXCIT_VAL", 0.0, c.name if c else ""),
    ("Channel", "DI_NUM_LINES"): _lines,
    ("Channel", "DO_NUM_LINES"): _lines,
    ("Channel", "CO_PULSE_DONE"): lambda s, t, c: t.done(s.clock),
    ("Channel", "PWR_OUTPUT_STATE"): lambda s, t, c: (
        15500 if c and t.get("PWR_OUTPUT_ENABLE", False, c.name) else 15503
    ),
    ("Timing", "SAMP_CLK_RATE"): _rate,
    ("Timing", "AI_CONV_RATE"): _convert_rate,
    ("Timing", "SAMP_CLK_TERM"): _clock_term,
    ("Trigger", "START_TRIG_TERM"): _start_term,
    ("Read", "OVERLOADED_CHANS_EXIST"): _overload,
    ("Read", "OPEN_CHANS_EXIST"): lambda s, t, c: bool(_dead(s, t, c)),
    ("Read", "OPEN_CHANS"): _dead,
    ("Read", "NUM_CHANS"): _count,
    ("Read", "CHANNELS_TO_READ"): _channels_to_read,
    ("Read", "TOTAL_SAMP_PER_CHAN_ACQUIRED"): _acquired,
    ("Read", "AVAIL_SAMP_PER_CHAN"): _available,
    ("Read", "CURR_READ_POS"): _moved,
    ("Read", "RAW_DATA_WIDTH"): _width,
    ("Read", "DIGITAL_LINES_BYTES_PER_CHAN"): _bytes,
    ("Write", "NUM_CHANS"): _count,
    ("Write", "TOTAL_SAMP_PER_CHAN_GENERATED"): _played,
    ("Write", "CURR_WRITE_POS"): lambda s, t, c: t.get("WRITTEN", 0),
    ("Write", "RAW_DATA_WIDTH"): _width,
    ("Write", "DIGITAL_LINES_BYTES_PER_CHAN"): _bytes,
    ("Write", "REGEN_MODE"): lambda s, t, c: (10097 if t.again else 10158) if isinstance(t, OutputTask) else None,
    ("Buffer", "INPUT_BUF_SIZE"): _buffer,
}
