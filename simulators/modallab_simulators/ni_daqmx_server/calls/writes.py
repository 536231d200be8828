"""Values for outputs: volts, codes, lines, pulses, waveforms."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import Task
from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem
from modallab_simulators.ni_daqmx_server.calls.channels import train
from modallab_simulators.ni_daqmx_server.counter_task import TICKS_HZ, CounterOutputTask, LineTask
from modallab_simulators.ni_daqmx_server.lines import Floats
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.status import StatusError

Answer = dict[str, Any]
BY_CHANNEL = 0
CODES = {"WriteBinaryI16": (np.int16, 2**15 - 1), "WriteBinaryU16": (np.uint16, 2**15 - 1),
         "WriteBinaryI32": (np.int32, 2**15 - 1), "WriteBinaryU32": (np.uint32, 2**15 - 1)}  # fmt: skip


def _arranged(request: Any, values: NDArray[Any], channels: int) -> NDArray[Any]:
    """(channels, samples), whatever the order on the wire."""
    count = len(values) // channels
    if len(values) != count * channels:
        raise StatusError(status.WRONG_CHANNELS, f"Number of Channels: {channels}\nNumber of Values: {len(values)}")
    if (request.data_layout_raw or request.data_layout) == BY_CHANNEL:
        return values.reshape(channels, count)
    return values.reshape(count, channels).T


def _put(system: SimulatedSystem, task: OutputTask, values: Floats, *, auto_start: bool) -> int:
    system.require_unexpired(task)
    outputs = (task, *task.others)
    if values.shape[0] != len(outputs):
        raise StatusError(
            status.WRONG_CHANNELS, f"Number of Channels in Task: {len(outputs)}\nin Data: {values.shape[0]}"
        )
    for output, row in zip(outputs, values, strict=True):
        limit = system.module_of(output.physical).output_range_v
        if np.abs(row).max(initial=0.0) > limit * (1 + 1e-9):
            raise StatusError(status.INVALID_VALUE, f"Property: AO.Write\nMaximum Value: {limit}")
    if task.rate_hz == 0 or auto_start:
        system.reserved.take(task)
    for output, row in zip(outputs, values, strict=True):
        output.write(row, system.clock)
    task.attributes["", "WRITTEN"] = task.get("WRITTEN", 0) + values.shape[1]
    if auto_start and not task.running:
        system.start(task)
    system.changed()
    return values.shape[1]


def analog(system: SimulatedSystem, request: Any) -> Answer:
    """Volts."""
    task = system.task(request.task.name, OutputTask)
    values = _arranged(request, np.array(request.write_array, dtype=np.float64), 1 + len(task.others))
    return {"samps_per_chan_written": _put(system, task, values, auto_start=request.auto_start)}


def analog_scalar(system: SimulatedSystem, request: Any) -> Answer:
    """One value for one output."""
    task = system.task(request.task.name, OutputTask)
    _put(system, task, np.array([[request.value]]), auto_start=request.auto_start)
    return {}


def codes(system: SimulatedSystem, request: Any, call: str) -> Answer:
    """Codes of the converter."""
    task = system.task(request.task.name, OutputTask)
    numbers = np.array(request.write_array, dtype=np.int64)
    full = CODES[call][1]
    volts = numbers / full * task.channels[0].module.output_range_v
    values = _arranged(request, volts, 1 + len(task.others))
    return {"samps_per_chan_written": _put(system, task, values, auto_start=request.auto_start)}


def raw(system: SimulatedSystem, request: Any) -> Answer:
    """Codes as bytes, all channels of a sample after one another."""
    task = system.task(request.task.name, Task)
    if isinstance(task, LineTask):
        width = _bytes_of(task)
        numbers = np.frombuffer(request.write_array, dtype=f"<u{width}").reshape(-1, len(task.channels)).T
        return {"samps_per_chan_written": _set_lines(system, task, numbers, auto_start=request.auto_start)}
    output = system.task(request.task.name, OutputTask)
    whole = int(request.num_samps) * (1 + len(output.others))
    numbers = np.frombuffer(request.write_array, dtype="<i2")[:whole].reshape(-1, 1 + len(output.others)).T
    volts = numbers / CODES["WriteBinaryI16"][1] * output.channels[0].module.output_range_v
    return {"samps_per_chan_written": _put(system, output, volts, auto_start=request.auto_start)}


def _bytes_of(task: LineTask) -> int:
    most = max(len(c.physical.split(",")) for c in task.channels)
    return 1 if most <= 8 else 2 if most <= 16 else 4


def _set_lines(system: SimulatedSystem, task: LineTask, numbers: NDArray[Any], *, auto_start: bool) -> int:
    """`numbers` (channels, samples): of each channel its lines, the first the lowest bit."""
    if numbers.shape[0] != len(task.channels):
        raise StatusError(
            status.WRONG_CHANNELS, f"Number of Channels in Task: {len(task.channels)}\nin Data: {numbers.shape[0]}"
        )
    columns = [
        (row.astype(np.uint64) >> np.uint64(bit)) & np.uint64(1)
        for channel, row in zip(task.channels, numbers, strict=True)
        for bit in range(len(channel.physical.split(",")))
    ]
    return _set_levels(system, task, np.stack(columns, axis=1).astype(np.bool_), auto_start=auto_start)


def _set_levels(system: SimulatedSystem, task: LineTask, levels: NDArray[np.bool_], *, auto_start: bool) -> int:
    system.reserved.take(task)
    task.write(levels)
    if auto_start and not task.running:
        system.start(task)
    return levels.shape[0]


def digital(system: SimulatedSystem, request: Any, call: str) -> Answer:
    """Ports: numbers whose lowest bit is the first line."""
    task = system.task(request.task.name, LineTask)
    given = request.write_array
    kind = {"WriteDigitalU8": "u1", "WriteDigitalU16": "u2", "WriteDigitalU32": "u4"}[call]
    values = np.frombuffer(given, dtype=kind) if isinstance(given, bytes) else np.array(given)
    numbers = _arranged(request, values, len(task.channels))
    return {"samps_per_chan_written": _set_lines(system, task, numbers, auto_start=request.auto_start)}


def digital_scalar(system: SimulatedSystem, request: Any) -> Answer:
    """One number for one channel."""
    task = system.task(request.task.name, LineTask)
    _set_lines(system, task, np.array([[request.value]]), auto_start=request.auto_start)
    return {}


def lines(system: SimulatedSystem, request: Any) -> Answer:
    """One byte a line."""
    task = system.task(request.task.name, LineTask)
    levels = np.frombuffer(request.write_array, dtype=np.uint8).astype(np.bool_)
    count = int(request.num_samps_per_chan)
    per_channel = len(levels) // (count * len(task.channels))
    if (request.data_layout_raw or request.data_layout) == BY_CHANNEL:
        shaped = levels.reshape(len(task.channels), count, per_channel).transpose(1, 0, 2)
    else:
        shaped = levels.reshape(count, len(task.channels), per_channel)
    picked = [shaped[:, n, : len(c.physical.split(","))] for n, c in enumerate(task.channels)]
    written = _set_levels(system, task, np.concatenate(picked, axis=1), auto_start=request.auto_start)
    return {"samps_per_chan_written": written}


def pulses(system: SimulatedSystem, request: Any, call: str) -> Answer:
    """Pulses of counters: those that are written last are given out from now on."""
    task = system.task(request.task.name, CounterOutputTask)
    first, second = _PAIRS[call.removesuffix("Scalar")]
    one, other = getattr(request, first), getattr(request, second)
    scalar = call.endswith("Scalar")
    pairs = [(one, other)] if scalar else list(zip(one, other, strict=True))
    if "Ticks" in call:
        pairs = [(a / TICKS_HZ, b / TICKS_HZ) for a, b in pairs]
    trains = pairs if "Freq" in call else [train(a, b) for a, b in pairs]
    if scalar or task.running:
        trains = trains[-len(task.channels) :]
    for place, channel in enumerate(task.channels):
        task.trains[channel.name] = trains[min(place, len(trains) - 1)]
    if request.auto_start and not task.running:
        system.start(task)
    return {} if scalar else {"num_samps_per_chan_written": request.num_samps_per_chan}


_PAIRS = {"WriteCtrFreq": ("frequency", "duty_cycle"), "WriteCtrTime": ("high_time", "low_time"),
          "WriteCtrTicks": ("high_ticks", "low_ticks")}  # fmt: skip


def analog_waveforms(system: SimulatedSystem, request: Any) -> Answer:
    """Volts, each channel with its times."""
    task = system.task(request.task.name, OutputTask)
    values = np.array([list(w.y_data) for w in request.waveforms], dtype=np.float64)
    return {"samps_per_chan_written": _put(system, task, values, auto_start=request.auto_start)}


def digital_waveforms(system: SimulatedSystem, request: Any) -> Answer:
    """Lines, each channel with its times."""
    task = system.task(request.task.name, LineTask)
    if len(request.waveforms) != len(task.channels):
        raise StatusError(status.WRONG_CHANNELS, f"Number of Channels: {len(task.channels)}")
    parts: list[NDArray[np.bool_]] = []
    for waveform, channel in zip(request.waveforms, task.channels, strict=True):
        width = len(channel.physical.split(","))
        if waveform.signal_count != width:
            raise StatusError(status.WRONG_LINES, f"Number of Lines: {width}\nin Data: {waveform.signal_count}")
        levels = np.frombuffer(waveform.y_data, dtype=np.uint8).reshape(-1, width)
        placed = np.empty_like(levels)
        placed[:, list(channel.wave_order or range(width))] = levels
        parts.append(placed.astype(np.bool_))
    written = _set_levels(system, task, np.concatenate(parts, axis=1), auto_start=request.auto_start)
    return {"samps_per_chan_written": written}
