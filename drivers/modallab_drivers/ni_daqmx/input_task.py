"""One input task: its channels, its clock, and what it delivers, as float32."""

import warnings
from collections.abc import Sequence
from math import ceil
from typing import Any

import nidaqmx.errors
import numpy as np
from nidaqmx.constants import AcquisitionType, Slope, TaskMode
from nidaqmx.stream_readers import AnalogMultiChannelReader
from numpy.typing import NDArray

from modallab.bench.capabilities import ReferenceTrigger
from modallab.core.errors import BenchError
from modallab.core.units import Test
from modallab_drivers.ni_daqmx.channels import add_channel
from modallab_drivers.ni_daqmx.errors import NEVER, NOT_YET, error_of_status, typed_error, typed_errors
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route

BUFFER_S = 10.0

_CEILING = 1000
"""A shorter buffer than so many samples a channel is not asked for."""


class InputTask:
    """A configured task on the inputs of one device, or of several that the driver takes together.

    The package hands out float64; float32 holds the 24 bits of the finest converter, and half the bytes are moved,
    stored and read again.
    """

    def __init__(self, route: Route, name: str, plugs: Sequence[Plug], test: Test) -> None:
        """Make the task and its channels.

        Args:
            route: to the devices.
            name: under which a server knows it.
            plugs: its channels.
            test: sets the sensitivities.

        Raises:
            ConfigurationError: a channel can't be had.
        """
        self.plugs = tuple(plugs)
        self.warnings: list[str] = []
        self.rate_hz = 0.0
        self._where = route.address.url
        with typed_errors(self._where):
            self.task: Any = route.task(name)
        try:
            self.volts_per_unit = np.array([add_channel(self.task, plug, test, self._where) for plug in plugs])
        except BaseException:
            self.close()
            raise
        self._reader: AnalogMultiChannelReader | None = None
        self._work = np.zeros(0)
        self._part = np.zeros((len(self.plugs), 0), dtype=np.float32)

    def set_clock(self, rate_hz: float, reference: ReferenceTrigger | None, channel: int = 0) -> None:
        """Set the clock and see which rate the device gives; with a trigger, on `channel`, for one finite record.

        Raises:
            ConfigurationError: the rate or the trigger can't be had.
        """
        timing = self.task.timing
        with typed_errors(f"{self._where}, rate_hz {rate_hz:g}"):
            if reference is None:
                timing.cfg_samp_clk_timing(rate_hz, sample_mode=AcquisitionType.CONTINUOUS)
            else:
                timing.cfg_samp_clk_timing(rate_hz, sample_mode=AcquisitionType.FINITE, samps_per_chan=reference.count)
                self._set_trigger(reference, channel)
            self.rate_hz = float(timing.samp_clk_rate)
            if reference is None:
                self.task.in_stream.input_buf_size = max(ceil(BUFFER_S * self.rate_hz), _CEILING)

    def _set_trigger(self, reference: ReferenceTrigger, channel: int) -> None:
        trigger = self.task.triggers.reference_trigger
        trigger.cfg_anlg_edge_ref_trig(
            self.plugs[channel].physical,
            reference.pre_trigger,
            trigger_slope=Slope.RISING if reference.level > 0 else Slope.FALLING,
            trigger_level=reference.level,
        )
        trigger.anlg_edge_hyst = reference.hysteresis

    def feed(self) -> None:
        """Switch the sensors' supply on where there is one: a committed task keeps it on from run to run.

        Raises:
            DeviceBusyError: another program holds an input.
        """
        if any(plug.channel.coupling == "IEPE" for plug in self.plugs):
            with typed_errors(self._where):
                self.task.control(TaskMode.TASK_COMMIT)

    def start(self) -> None:
        """Begin to sample."""
        self._part = self._part[:, :0]
        with typed_errors(self._where):
            self.task.start()

    def stop(self) -> None:
        """Stop sampling."""
        with typed_errors(self._where):
            self.task.stop()

    def close(self) -> None:
        """Let go of the task; a device that is gone has let go already."""
        try:
            self.task.close()
        except nidaqmx.errors.Error as error:
            self.warnings.append(str(typed_error(error, self._where)))

    def acquired(self) -> int:
        """Samples per channel the device has acquired since the start."""
        with typed_errors(self._where):
            return int(self.task.in_stream.total_samp_per_chan_acquired)

    def fill(self, count: int, timeout_s: float) -> int:
        """Read until `count` samples a channel are at hand, or the time is over; returns how many are.

        Raises:
            SamplesLostError: the device lost samples.
            DeviceGoneError: it is gone.
        """
        missing = count - self._part.shape[1]
        if missing > 0:
            fresh = self._read(missing, timeout_s)
            self._part = np.concatenate([self._part, fresh], axis=1) if self._part.size else fresh
        return self._part.shape[1]

    def take(self, count: int) -> NDArray[np.float32]:
        """The next (channels, count) values of those at hand."""
        taken, self._part = self._part[:, :count], self._part[:, count:]
        return taken

    def _read(self, count: int, timeout_s: float) -> NDArray[np.float32]:
        size = len(self.plugs) * count
        if self._work.size < size:
            self._work = np.empty(size)
        target = self._work[:size].reshape(len(self.plugs), count)
        return target[:, : self._read_into(target, count, timeout_s)].astype(np.float32)

    def _read_into(self, target: NDArray[np.float64], count: int, timeout_s: float) -> int:
        if self._reader is None:
            self._reader = AnalogMultiChannelReader(self.task.in_stream)
            # Checking the shape would cost a call a read.
            self._reader.verify_array_shape = False
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", nidaqmx.errors.DaqWarning)
                came = int(self._reader.read_many_sample(target, count, timeout=timeout_s))
            self.warnings += [str(warning.message) for warning in caught]
        except nidaqmx.errors.DaqReadError as error:
            if int(error.error_code) != NOT_YET:
                raise self._ended(error) from error
            came = int(error.samps_per_chan_read)
        except nidaqmx.errors.Error as error:
            raise typed_error(error, self._where) from error
        return came

    def _ended(self, error: Any) -> BenchError:
        kept = self._part.shape[1]
        text = f"{error}" if int(error.error_code) != NEVER else f"{error} {kept} samples had been received before"
        return error_of_status(int(error.error_code), text, self._where)

    def convert_rate_hz(self) -> float | None:
        """Rate at which a multiplexer steps from channel to channel; None where every channel has its own converter."""
        try:
            return float(self.task.timing.ai_conv_rate)
        except nidaqmx.errors.DaqError:
            return None

    def filter_delays_s(self) -> list[float]:
        """By how much each channel's digital filter makes its samples lag; 0 where the device names none."""
        delays: list[float] = []
        for plug in self.plugs:
            try:
                delays.append(float(self.task.ai_channels[plug.physical].ai_filter_delay))
            except nidaqmx.errors.DaqError:
                delays.append(0.0)
        return delays
