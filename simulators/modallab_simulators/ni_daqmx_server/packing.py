"""Samples in the answers to reads: as numbers, codes, bits, pairs or waveforms."""

from collections.abc import Callable
from dataclasses import dataclass
from time import time
from typing import Any

import numpy as np
from ni.protobuf.types import waveform_pb2
from numpy.typing import NDArray

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Channel
from modallab_simulators.ni_daqmx_server.input_task import InputTask

BY_CHANNEL = 0
EPOCH_1904_S = 2_082_844_800
POWER_CODES = (4096.0, 8192.0)
_WAVEFORMS: Any = waveform_pb2
Fill = Callable[[Any, Any, AcquiringTask, NDArray[Any], int], Any]


@dataclass(frozen=True, slots=True)
class MessageForm:
    """How a kind of read answers.

    Attributes:
        fill: puts (channels, samples) values into the answer.
        scalar: whether it reads one sample of one channel.
    """

    fill: Fill
    scalar: bool = False


def _ordered(asked: Any, values: NDArray[Any], room: int) -> NDArray[Any]:
    # The array on the wire is as long as was asked for, whatever came.
    whole = np.zeros((values.shape[0], max(room, values.shape[1]), *values.shape[2:]), dtype=values.dtype)
    whole[:, : values.shape[1]] = values
    by_channel = not hasattr(asked, "fill_mode_raw") or (asked.fill_mode_raw or asked.fill_mode) == BY_CHANNEL
    return (whole if by_channel else whole.swapaxes(0, 1)).reshape(-1, *values.shape[2:])


def _volts(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    """Packed by hand: as the generated classes would, at a fraction of their time."""
    response.samps_per_chan_read = values.shape[1]
    body = _ordered(asked, values, count).astype("<f8", copy=False).tobytes()
    return response.SerializeToString() + b"\x12" + _varint(len(body)) + body


def _varint(value: int) -> bytes:
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def _scalar(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    response.value = values.flat[0]
    return response


def codes_of(task: AcquiringTask, values: NDArray[Any]) -> NDArray[np.int64]:
    """Codes of the converters."""
    assert isinstance(task, InputTask)
    full = np.array([2 ** (min(c.module.bits, 16 if c.module.simulated else 32) - 1) - 1 for c in task.channels])
    per_code = np.array([c.module.input_range_v * c.per_volt for c in task.channels]) / full
    return np.floor(values / per_code[:, None]).astype(np.int64)


def _codes(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    codes = codes_of(task, values)
    if "U" in type(response).__name__.removeprefix("Read"):
        codes = np.maximum(codes, 0)
    response.read_array.extend(_ordered(asked, codes, values.shape[1]).tolist())
    response.samps_per_chan_read = values.shape[1]
    return response


def _raw(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    channels = task.all_channels()
    if isinstance(task, InputTask):
        kind = "<i4" if channels[0].module.bits > 16 else "<i2"
        codes: NDArray[Any] = codes_of(task, values)
    else:
        lines = max(len(c.physical.split(",")) for c in channels)
        kind, codes = ("<u1" if lines <= 8 else "<u2" if lines <= 16 else "<u4"), values
    # The array on the wire is as long as was asked for, whatever came.
    response.read_array = codes.T.astype(kind).tobytes().ljust(asked.array_size_in_bytes, b"\0")
    response.samps_read = values.shape[1]
    response.num_bytes_per_samp = np.dtype(kind).itemsize
    return response


def _ports(kind: str) -> Fill:
    def fill(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
        ordered = _ordered(asked, values, values.shape[1]).astype(kind)
        if isinstance(response.read_array, bytes):
            response.read_array = ordered.tobytes()
        else:
            response.read_array.extend(ordered.tolist())
        response.samps_per_chan_read = values.shape[1]
        return response

    return fill


def bits_of(channel: Channel, numbers: NDArray[Any]) -> NDArray[np.uint8]:
    """(samples, lines) levels of a channel."""
    lines = np.arange(len(channel.physical.split(",")), dtype=np.uint32)
    return (numbers.astype(np.uint32)[:, None] >> lines & np.uint32(1)).astype(np.uint8)


def _lines(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    channels = task.all_channels()
    width = max(len(c.physical.split(",")) for c in channels)
    levels = np.zeros((len(channels), values.shape[1], width), dtype=np.uint8)
    for place, channel in enumerate(channels):
        bits = bits_of(channel, values[place])
        levels[place, :, : bits.shape[1]] = bits
    response.read_array = _ordered(asked, levels, values.shape[1]).tobytes()
    response.samps_per_chan_read = values.shape[1]
    response.num_bytes_per_samp = width
    return response


def _counts(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    found = _ordered(asked, values[..., 0], values.shape[1])
    whole = "U32" in type(response).__name__
    response.read_array.extend(found.astype(np.int64).tolist() if whole else found.tolist())
    response.samps_per_chan_read = values.shape[1]
    return response


def _count(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    value = values[0, 0, 0]
    response.value = int(value) if "U32" in type(response).__name__ else value
    return response


def _pairs(first: str, second: str, *, scalar: bool) -> Fill:
    def fill(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
        both = values.reshape(-1, 2)
        both = both.astype(np.int64) if "Ticks" in type(response).__name__ else both
        if scalar:
            setattr(response, first, both[0, 0].item())
            setattr(response, second, both[0, 1].item())
            return response
        getattr(response, f"read_array_{first}").extend(both[:, 0].tolist())
        getattr(response, f"read_array_{second}").extend(both[:, 1].tolist())
        response.samps_per_chan_read = values.shape[1]
        return response

    return fill


def _power(scale: tuple[float, float] | None, *, scalar: bool = False) -> Fill:
    def fill(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
        amps = np.array([task.get("PWR_CURRENT_SETPOINT", 0.0, c.name) for c in task.all_channels()])
        currents = np.broadcast_to(amps[:, None], values.shape)
        if scalar:
            response.voltage, response.current = values[0, 0], currents[0, 0]
            return response
        for field, found, factor in (("voltage", values, 0), ("current", currents, 1)):
            ordered = _ordered(asked, found, values.shape[1])
            array = np.round(ordered * scale[factor]).astype(np.int64) if scale else ordered
            getattr(response, f"read_array_{field}").extend(array.tolist())
        response.samps_per_chan_read = values.shape[1]
        return response

    return fill


def _times(waveform: Any, task: AcquiringTask, first: int, asked: Any) -> None:
    mode = asked.waveform_attribute_mode_raw or asked.waveform_attribute_mode
    if mode & 1 and task.timing == "clocked":
        began = time() - (task.position - first) / task.true_hz + EPOCH_1904_S
        waveform.t0.seconds = int(began)
        waveform.t0.fractional_seconds = int((began % 1) * 2**64)
        waveform.dt = 1 / task.rate_hz


def _analog_waveforms(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    mode = asked.waveform_attribute_mode_raw or asked.waveform_attribute_mode
    for channel, row in zip(task.all_channels(), values, strict=True):
        waveform = _WAVEFORMS.DoubleAnalogWaveform(y_data=row)
        _times(waveform, task, task.position - values.shape[1], asked)
        if mode & 2:
            waveform.attributes["NI_ChannelName"].string_value = channel.name
            waveform.attributes["NI_UnitDescription"].string_value = "Volts"
        response.waveforms.append(waveform)
    response.samps_per_chan_read = values.shape[1]
    return response


def _digital_waveforms(response: Any, asked: Any, task: AcquiringTask, values: NDArray[Any], count: int) -> Any:
    mode = asked.waveform_attribute_mode_raw or asked.waveform_attribute_mode
    for channel, row in zip(task.all_channels(), values, strict=True):
        order = list(channel.wave_order or range(len(channel.physical.split(","))))
        bits = np.ascontiguousarray(bits_of(channel, row)[:, order])
        waveform = _WAVEFORMS.DigitalWaveform(y_data=bits.tobytes(), signal_count=bits.shape[1])
        _times(waveform, task, task.position - values.shape[1], asked)
        if mode & 2:
            waveform.attributes["NI_ChannelName"].string_value = channel.name
            waveform.attributes["NI_LineNames"].string_value = ", ".join(channel.physical.split(",")[n] for n in order)
        response.waveforms.append(waveform)
    response.samps_per_chan_read = values.shape[1]
    return response


FORMS: dict[str, MessageForm] = {
    "ReadAnalogF64": MessageForm(_volts),
    "ReadAnalogScalarF64": MessageForm(_scalar, scalar=True),
    "ReadRaw": MessageForm(_raw),
    "ReadDigitalU8": MessageForm(_ports("u1")),
    "ReadDigitalU16": MessageForm(_ports("u2")),
    "ReadDigitalU32": MessageForm(_ports("u4")),
    "ReadDigitalScalarU32": MessageForm(_scalar, scalar=True),
    "ReadDigitalLines": MessageForm(_lines),
    "ReadCounterScalarF64": MessageForm(_count, scalar=True),
    "ReadCounterScalarU32": MessageForm(_count, scalar=True),
    "ReadPowerF64": MessageForm(_power(None)),
    "ReadPowerScalarF64": MessageForm(_power(None, scalar=True), scalar=True),
    "ReadPowerBinaryI16": MessageForm(_power(POWER_CODES)),
    "ReadAnalogWaveforms": MessageForm(_analog_waveforms),
    "ReadDigitalWaveforms": MessageForm(_digital_waveforms),
}
FORMS.update({f"ReadBinary{k}": MessageForm(_codes) for k in ("I16", "U16", "I32", "U32")})
FORMS.update({f"ReadCounter{k}{e}": MessageForm(_counts) for k in ("F64", "U32") for e in ("", "Ex")})
for _name, _fields in {"Freq": ("frequency", "duty_cycle"), "Time": ("high_time", "low_time"),
                       "Ticks": ("high_ticks", "low_ticks")}.items():  # fmt: skip
    FORMS[f"ReadCtr{_name}"] = MessageForm(_pairs(*_fields, scalar=False))
    FORMS[f"ReadCtr{_name}Scalar"] = MessageForm(_pairs(*_fields, scalar=True), scalar=True)
