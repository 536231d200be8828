"""The input task: made from the rig, read by a stream reader into arrays of our own."""

import time
import warnings
from collections.abc import Sequence
from math import ceil
from typing import Any

import nidaqmx.errors
import numpy as np
from nidaqmx.constants import AcquisitionType, Slope
from nidaqmx.stream_readers import AnalogMultiChannelReader
from numpy.typing import NDArray

from modallab.bench.protocol import ReferenceTrigger
from modallab.core.errors import BenchError, BenchTimeoutError, ConfigurationError
from modallab.core.units import Test
from modallab_drivers.ni_daqmx.channels import add_channel
from modallab_drivers.ni_daqmx.errors import NEVER, NOT_YET, UNSUPPORTED_HERE, of_code, translated, typed
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route

BUFFER_S = 10.0
FAULT_POLL_S = 1.0

_UNSUPPORTED = (UNSUPPORTED_HERE, -200077, -200197)
"""What a device says that has no such flag."""


def session_name(device: str) -> str:
    """Name under which a server knows the input task: what a killed client leaves behind is recognised by it."""
    return f"modallab-inputs-{device}"


class Inputs:
    """A configured input task. It keeps what a timed-out read had brought."""

    def __init__(
        self,
        route: Route,
        plugs: Sequence[Plug],
        test: Test,
        rate_hz: float,
        reference: ReferenceTrigger | None = None,
    ) -> None:
        """Make the task, set its clock, and see which rate the device gives; with a trigger for one finite record.

        Raises:
            ConfigurationError: a channel or the rate can't be had.
        """
        self._plugs = tuple(plugs)
        self._where = route.address.url
        self.warnings: list[str] = []
        with translated(self._where):
            self._task = route.task(session_name(route.address.device))
        try:
            self.volts_per_unit = np.array([add_channel(self._task, plug, test, self._where) for plug in plugs])
            with translated(f"{self._where}, rate_hz {rate_hz:g}"):
                self._set_clock(rate_hz, reference)
                self.rate_hz = float(self._task.timing.samp_clk_rate)
                if reference is None:
                    self._task.in_stream.input_buf_size = max(ceil(BUFFER_S * self.rate_hz), 1000)
        except BaseException:
            self.close()
            raise
        self.delay_s = self._filter_delay()
        self._reader = AnalogMultiChannelReader(self._task.in_stream)
        # Checking the shape would cost a call a read.
        self._reader.verify_array_shape = False
        self._part = np.zeros((len(plugs), 0))
        self._flags = True
        self._polls_faults = any(plug.channel.coupling in ("IEPE", "bridge") for plug in plugs)
        self._polled_s = 0.0
        self.open_unseen = False

    def _set_clock(self, rate_hz: float, reference: ReferenceTrigger | None) -> None:
        timing = self._task.timing
        if reference is None:
            timing.cfg_samp_clk_timing(rate_hz, sample_mode=AcquisitionType.CONTINUOUS)
            return
        timing.cfg_samp_clk_timing(rate_hz, sample_mode=AcquisitionType.FINITE, samps_per_chan=reference.count)
        trigger = self._task.triggers.reference_trigger
        trigger.cfg_anlg_edge_ref_trig(
            self._plugs[reference.channel].physical,
            reference.pre_trigger,
            trigger_slope=Slope.RISING if reference.level > 0 else Slope.FALLING,
            trigger_level=reference.level,
        )
        trigger.anlg_edge_hyst = reference.hysteresis

    def start(self) -> None:
        """Begin to sample."""
        self._part = np.zeros((len(self._plugs), 0))
        with translated(self._where):
            self._task.start()

    def stop(self) -> None:
        """Stop sampling."""
        with translated(self._where):
            self._task.stop()

    def close(self) -> None:
        """Let go of the task; a device that is gone has let go already."""
        try:
            self._task.close()
        except nidaqmx.errors.Error as error:
            self.warnings.append(str(typed(error, self._where)))

    def acquired(self) -> int:
        """Samples per channel the device has acquired since the start."""
        with translated(self._where):
            return int(self._task.in_stream.total_samp_per_chan_acquired)

    def read(self, count: int, timeout_s: float) -> NDArray[np.float64]:
        """The next (channels, count) values.

        Raises:
            BenchTimeoutError: not all came in time; what came is kept for the next read.
            SamplesLostError: the device lost samples.
            DeviceGoneError: it is gone.
        """
        missing = count - self._part.shape[1]
        if missing <= 0:
            taken, self._part = self._part[:, :count], self._part[:, count:]
            return taken
        fresh = np.empty((len(self._plugs), missing))
        came = self._fill(fresh, missing, timeout_s)
        whole = np.concatenate([self._part, fresh[:, :came]], axis=1) if self._part.size or came < missing else fresh
        if came < missing:
            self._part = whole
            raise BenchTimeoutError(
                f"{whole.shape[1]} of {count} samples came within {timeout_s:g} s ({NOT_YET})",
                where=self._where,
                remedy="wait longer; what came is kept",
            )
        self._part = whole[:, :0]
        return whole

    def _fill(self, fresh: NDArray[np.float64], count: int, timeout_s: float) -> int:
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", nidaqmx.errors.DaqWarning)
                came = int(self._reader.read_many_sample(fresh, count, timeout=timeout_s))
            self.warnings += [str(warning.message) for warning in caught]
        except nidaqmx.errors.DaqReadError as error:
            if int(error.error_code) != NOT_YET:
                raise self._ended(error) from error
            came = int(error.samps_per_chan_read)
        except nidaqmx.errors.Error as error:
            raise typed(error, self._where) from error
        return came

    def _ended(self, error: Any) -> BenchError:
        kept = self._part.shape[1]
        text = f"{error}" if int(error.error_code) != NEVER else f"{error} {kept} samples had come before"
        return of_code(int(error.error_code), text, self._where)

    def overloaded(self) -> NDArray[np.bool_]:
        """(channels,) whether the device saw a channel beyond its range since it was last asked."""
        flags = np.zeros(len(self._plugs), dtype=np.bool_)
        if not self._flags:
            return flags
        try:
            # Asking whether clears the flags, and must come before asking which.
            if self._task.in_stream.overloaded_chans_exist:
                names = set(self._task.in_stream.overloaded_chans)
                flags |= np.array([plug.physical in names for plug in self._plugs])
        except nidaqmx.errors.DaqError as error:
            if int(error.error_code) not in _UNSUPPORTED:
                raise typed(error, self._where) from error
            self._flags = False
        return flags

    def require_sensors(self) -> None:
        """Look, once in a while, whether a fed sensor is unplugged or shorted.

        Raises:
            BenchError: names the channels.
        """
        if not self._polls_faults or time.monotonic() - self._polled_s < FAULT_POLL_S:
            return
        self._polled_s = time.monotonic()
        stream = self._task.in_stream
        for what, exist, which in (
            ("open: no sensor is connected", "open_chans_exist", "open_chans"),
            ("without excitation: a short, or no power", "excit_fault_chans_exist", "excit_fault_chans"),
        ):
            try:
                found = list(getattr(stream, which)) if getattr(stream, exist) else []
            except nidaqmx.errors.DaqError as error:
                if int(error.error_code) not in _UNSUPPORTED:
                    raise typed(error, self._where) from error
                self.open_unseen |= exist == "open_chans_exist"
                continue
            if found:
                names = [plug.channel.name for plug in self._plugs if plug.physical in found]
                raise BenchError(
                    f"channel {', '.join(names)} is {what}", where=self._where, remedy="look at its cable and sensor"
                )

    def convert_rate_hz(self) -> float | None:
        """Rate at which a multiplexer steps from channel to channel; None where every channel has its own converter."""
        try:
            return float(self._task.timing.ai_conv_rate)
        except nidaqmx.errors.DaqError:
            return None

    def _filter_delay(self) -> float:
        delays: list[float] = []
        for plug in self._plugs:
            try:
                delays.append(float(self._channel(plug).ai_filter_delay))
            except nidaqmx.errors.DaqError:
                delays.append(0.0)
        if max(delays) - min(delays) > 0.1 / self.rate_hz:
            listed = ", ".join(f"{p.channel.name} {1e3 * d:.3g} ms" for p, d in zip(self._plugs, delays, strict=True))
            self.close()
            raise ConfigurationError(
                f"modules of different delay in one task: {listed}",
                where=f"{self._where}, rig file field channels[].input",
                remedy="put all channels on modules of one kind",
            )
        return max(delays)

    def _channel(self, plug: Plug) -> Any:
        return self._task.ai_channels[plug.physical]
