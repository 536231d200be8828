"""Devices of openDAQ's family, among them its own reference device: `daqref://device0`.

Only what every openDAQ device has is used: channels with a signal, a rate, and a stream reader.
"""

import re
import time
from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import AcquisitionRequest, Bench, BenchInfo, DeliveredSampling, FoundDevice, SampleChunk
from modallab.core.discovery import how_to_install
from modallab.core.errors import (
    BenchTimeoutError,
    ConfigurationError,
    DeviceGoneError,
    SamplesLostError,
)
from modallab.core.rig import Channel, Rig
from modallab_drivers.output import NoOutput, require_count

MOST_RATE_HZ = 200_000.0
POLL_S = 0.002
_RATE = "GlobalSampleRate"
_COUNT = "NumberOfChannels"


def open_bench(url: str, rig: Rig) -> Bench:
    """Open the device at an openDAQ connection string.

    Raises:
        ConfigurationError: the address, or a field of the rig file that does not fit the device.
        DeviceGoneError: no openDAQ, or no such device.
    """
    try:
        import opendaq
    except ImportError as error:
        raise DeviceGoneError(
            "openDAQ is not installed",
            where=url,
            remedy=f"{how_to_install('opendaq')}, on Linux or Windows with an x86-64 processor",
        ) from error
    return OpenDaqBench(url, rig, opendaq)


def find_devices(address: str) -> list[FoundDevice]:
    """Devices openDAQ sees."""
    try:
        import opendaq
    except ImportError:
        return []
    instance: Any = opendaq.Instance()
    return [FoundDevice(str(d.connection_string), f"openDAQ: {d.name}") for d in instance.available_devices]


class OpenDaqBench(NoOutput):
    """Inputs of one openDAQ device: for each channel of the rig the one it names, or else the next in order."""

    def __init__(self, url: str, rig: Rig, opendaq: Any) -> None:
        self._url, self._rig, self._opendaq = url, rig, opendaq
        self._state = "open"
        self._instance: Any = opendaq.Instance()
        # "daqref://" alone is the first reference device.
        address = url if url.partition("://")[2] else f"{url}device0"
        try:
            self._device: Any = self._instance.add_device(address)
        except RuntimeError as error:
            raise DeviceGoneError(str(error), where=url, remedy=self._known()) from error
        self._channels = self._fitting_channels()
        self._reader: Any = None
        self._position = 0
        info = self._device.info
        self._info = BenchInfo(
            url,
            ((str(info.model or self._device.name), str(info.serial_number)),),
            can_drive=False,
            real_time=True,
            facts={f"input of {c.name}": str(d.name) for c, d in zip(rig.channels, self._channels, strict=True)},
        )

    @property
    def info(self) -> BenchInfo:
        """What answers."""
        return self._info

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """Set the device's rate and read back what it became."""
        self._require("open", "configured", "stopped", "lost", to="configure")
        if not isfinite(request.rate_hz) or not 0 < request.rate_hz <= MOST_RATE_HZ:
            raise ConfigurationError(
                f"rate_hz is {request.rate_hz}", where=self._url, remedy=f"ask for up to {MOST_RATE_HZ:g} Hz"
            )
        self._drop_reader()
        self._device.set_property_value(_RATE, float(request.rate_hz))
        actual = float(self._device.get_property_value(_RATE))
        self._rate_hz = actual
        self._state = "configured"
        units = tuple(
            self._unit(channel, device) for channel, device in zip(self._rig.channels, self._channels, strict=True)
        )
        scale = np.ones(len(units))
        return DeliveredSampling(request.rate_hz, actual, actual, np.dtype(np.float64), scale, units)

    def start(self) -> None:
        """Begin with a reader of its own, whose first common sample is sample 0."""
        self._require("configured", "stopped", "lost", to="start")
        signals = [device.signals[0] for device in self._channels]
        read_all = self._opendaq.MultiReader(signals, self._opendaq.SampleType.Float64, self._opendaq.SampleType.Int64)
        self._drop_reader()
        self._reader = read_all
        self._left = np.zeros((len(self._channels), 0))
        self._position = 0
        self._state = "running"

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """The next `count` samples of all channels."""
        self._require("running", to="read")
        require_count(count, self._url)
        deadline = time.monotonic() + timeout_s
        while self._left.shape[1] < count:
            fresh = self._pull(count - self._left.shape[1])
            if fresh.shape[1]:
                self._left = np.concatenate([self._left, fresh], axis=1)
            elif time.monotonic() >= deadline:
                raise BenchTimeoutError(
                    f"{self._left.shape[1]} of {count} samples came within {timeout_s:g} s",
                    where=self._url,
                    remedy="wait longer; samples received so far are kept",
                )
            else:
                time.sleep(POLL_S)
        samples, self._left = self._left[:, :count].copy(), self._left[:, count:]
        first, self._position = self._position, self._position + count
        return SampleChunk(first, samples, self._at_full_scale(samples))

    def stop(self) -> None:
        """Stop reading."""
        if self._state in ("running", "lost"):
            self._drop_reader()
            self._state = "stopped"

    def close(self) -> None:
        """Let go of the device."""
        if self._state == "closed":
            return
        self._drop_reader()
        self._instance.remove_device(self._device)
        self._state = "closed"

    def _pull(self, count: int) -> NDArray[np.float64]:
        values, status = self._reader.read(count, timeout_ms=20, return_status=True)
        if not status.valid:
            self._state = "lost"
            raise SamplesLostError(
                f"the stream was broken after sample {self._position + self._left.shape[1]}",
                where=self._url,
                remedy="start again, with a gap in the samples",
            )
        return np.asarray(values, dtype=np.float64).reshape(len(self._channels), -1)

    def _drop_reader(self) -> None:
        self._reader = None

    def _fitting_channels(self) -> Sequence[Any]:
        wanted = self._rig.channels
        needed = max(len(wanted), *(_place_of(channel.input) for channel in wanted))
        if self._device.has_property(_COUNT) and int(self._device.get_property_value(_COUNT)) < needed:
            # The reference device has as many channels as one asks for.
            self._device.set_property_value(_COUNT, needed)
        channels: list[Any] = list(self._device.channels_recursive)
        if len(channels) < len(wanted):
            raise ConfigurationError(
                f"channels: the rig has {len(wanted)}, the device {len(channels)}",
                where=self._url,
                remedy="leave channels of the rig file out, or use a larger device",
            )
        named = {channel.input: self._named(channel, channels) for channel in wanted if channel.input}
        taken = {str(device.global_id) for device in named.values()}
        free = iter([device for device in channels if str(device.global_id) not in taken])
        return [named[channel.input] if channel.input else next(free) for channel in wanted]

    def _named(self, channel: Channel, channels: Sequence[Any]) -> Any:
        for device in channels:
            if channel.input in _names_of(device):
                return device
        listed = ", ".join(str(device.name) for device in channels)
        raise ConfigurationError(
            f"channels[{channel.index}].input: found {channel.input!r}; allowed: {listed}",
            where=self._url,
            remedy="correct this field of the rig file",
        )

    def _unit(self, channel: Channel, device: Any) -> str:
        unit = device.signals[0].descriptor.unit
        symbol = str(unit.symbol) if unit is not None else ""
        if symbol not in ("V", "mV"):
            raise ConfigurationError(
                f"channel {channel.name} is delivered in {symbol!r}", where=self._url, remedy="set the channel to volts"
            )
        return symbol

    def _at_full_scale(self, samples: NDArray[np.float64]) -> NDArray[np.bool_]:
        limits = [device.signals[0].descriptor.value_range for device in self._channels]
        highest = np.array([np.inf if r is None else float(r.high_value) for r in limits])
        lowest = np.array([-np.inf if r is None else float(r.low_value) for r in limits])
        return (samples.max(axis=1) >= highest) | (samples.min(axis=1) <= lowest)

    def _known(self) -> str:
        found = ", ".join(str(device.connection_string) for device in self._instance.available_devices)
        return f"openDAQ sees: {found or 'none'}"


def _names_of(device: Any) -> tuple[str, ...]:
    """What a rig file may call a channel: its name, its id in part or in whole, or its signal's name."""
    signal = device.signals[0]
    return (str(device.name), str(device.local_id), str(device.global_id), str(signal.name), str(signal.local_id))


def _place_of(name: str) -> int:
    digits = re.search(r"\d+$", name)
    return int(digits.group()) + 1 if digits else 0
