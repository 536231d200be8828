"""All inputs of a bench, on one clock, and what a device says of them while it samples."""

import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import nidaqmx.errors
import numpy as np
from numpy.typing import NDArray

from modallab.bench.capabilities import ReferenceTrigger, SyncState
from modallab.core.errors import BenchError, BenchTimeoutError, ConfigurationError
from modallab.core.hardware import Synchronisation
from modallab.core.units import Test
from modallab_drivers.ni_daqmx.errors import NOT_YET, UNSUPPORTED_HERE, typed_error
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route
from modallab_drivers.ni_daqmx.synchronise import synchronised_tasks

FAULT_POLL_S = 1.0

_UNSUPPORTED = (UNSUPPORTED_HERE, -200077, -200197)
"""What a device says that has no such flag."""


class InputFaults:
    """The flags of one task."""

    def __init__(self, task: Any, plugs: Sequence[Plug], where: str) -> None:
        """Look at `task`, whose channels are `plugs`."""
        self._task, self._plugs, self._where = task, tuple(plugs), where
        self._flags = True
        self._fed = any(plug.channel.coupling in ("IEPE", "bridge") for plug in plugs)
        self._polled_s = 0.0
        self._open_unseen = False

    def open_unseen(self) -> tuple[str, ...]:
        """Names of fed channels of which the device cannot say whether a sensor is there; known after a first look."""
        fed = [plug.channel.name for plug in self._plugs if plug.channel.coupling in ("IEPE", "bridge")]
        return tuple(fed) if self._open_unseen else ()

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
                raise typed_error(error, self._where) from error
            self._flags = False
        return flags

    def require_sensors(self) -> None:
        """Look, once in a while, whether a fed sensor is unplugged or shorted.

        Raises:
            BenchError: names the channels.
        """
        if not self._fed or time.monotonic() - self._polled_s < FAULT_POLL_S:
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
                    raise typed_error(error, self._where) from error
                self._open_unseen |= exist == "open_chans_exist"
                continue
            if found:
                names = [plug.channel.name for plug in self._plugs if plug.physical in found]
                raise BenchError(
                    f"channel {', '.join(names)} is {what}", where=self._where, remedy="check its cable and sensor"
                )

    def unlocked(self) -> list[str]:
        """Channels whose clock has lost the reference it should follow; empty where the device has no such flag."""
        try:
            stream = self._task.in_stream
            return list(stream.pll_unlocked_chans) if stream.pll_unlocked_chans_exist else []
        except nidaqmx.errors.DaqError as error:
            if int(error.error_code) not in _UNSUPPORTED:
                raise typed_error(error, self._where) from error
            return []


DELAY_PART = 0.1
"""Channels may lag each other by so many samples."""


class Inputs:
    """The inputs, in the order of the plugs. It keeps what a timed-out read had brought.

    Attributes:
        rate_hz: that the devices give.
        volts_per_unit: (channels,) as delivered.
        delay_s: by how much the samples lag what the sensors felt.
        synchronised_by: in words; empty where one device samples all.
        reference_clock: of the backplane, which all devices follow; empty where they do not.
    """

    def __init__(
        self,
        route: Route,
        plugs: Sequence[Plug],
        test: Test,
        rate_hz: float,
        reference: ReferenceTrigger | None = None,
        synchronisation: Synchronisation | None = None,
    ) -> None:
        """Make the tasks, set their clock, and see which rate the devices give.

        Raises:
            ConfigurationError: a channel, the rate or a common clock can't be had.
            DeviceBusyError: another program holds an input.
        """
        self._where = route.address.url
        made = synchronised_tasks(route, plugs, test, rate_hz, reference, synchronisation or Synchronisation())
        self.tasks, self.synchronised_by = made.tasks, made.synchronised_by
        self.reference_clock = made.reference_clock
        self._rows = [[plugs.index(plug) for plug in task.plugs] for task in self.tasks]
        self._faults = [InputFaults(task.task, task.plugs, self._where) for task in self.tasks]
        self._channels = len(plugs)
        self.rate_hz = self.tasks[0].rate_hz
        self.volts_per_unit = np.empty(self._channels)
        for rows, task in zip(self._rows, self.tasks, strict=True):
            self.volts_per_unit[rows] = task.volts_per_unit
        try:
            self.delay_s = self._filter_delay(plugs)
            for task in self.tasks:
                task.feed()
        except BaseException:
            self.close()
            raise

    @property
    def warnings(self) -> list[str]:
        """What the driver warned of."""
        return [warning for task in self.tasks for warning in task.warnings]

    def start(self) -> None:
        """Begin to sample: the first task last, since the others wait for its start."""
        for task in reversed(self.tasks):
            task.start()

    def stop(self) -> None:
        """Stop sampling."""
        for task in self.tasks:
            task.stop()

    def close(self) -> None:
        """Let go of the tasks."""
        for task in self.tasks:
            task.close()

    def acquired(self) -> int:
        """Samples per channel the devices have acquired since the start."""
        return min(task.acquired() for task in self.tasks)

    def read(self, count: int, timeout_s: float) -> NDArray[np.float32]:
        """The next (channels, count) values.

        Raises:
            BenchTimeoutError: not all came in time; what came is kept for the next read.
            SamplesLostError: the device lost samples.
            DeviceGoneError: it is gone.
        """
        deadline = time.monotonic() + timeout_s
        came = min(task.fill(count, max(0.0, deadline - time.monotonic())) for task in self.tasks)
        if came < count:
            raise BenchTimeoutError(
                f"{came} of {count} samples came within {timeout_s:g} s ({NOT_YET})",
                where=self._where,
                remedy="wait longer; samples received so far are kept",
            )
        if len(self.tasks) == 1:
            return self.tasks[0].take(count)
        whole = np.empty((self._channels, count), dtype=np.float32)
        for rows, task in zip(self._rows, self.tasks, strict=True):
            whole[rows] = task.take(count)
        return whole

    def overloaded(self) -> NDArray[np.bool_]:
        """(channels,) whether a device saw a channel beyond its range since it was last asked."""
        flags = np.zeros(self._channels, dtype=np.bool_)
        for rows, faults in zip(self._rows, self._faults, strict=True):
            flags[rows] = faults.overloaded()
        return flags

    def require_sensors(self) -> None:
        """Look, once in a while, whether a fed sensor is unplugged or shorted.

        Raises:
            BenchError: names the channels.
        """
        for faults in self._faults:
            faults.require_sensors()

    def open_unseen(self) -> tuple[str, ...]:
        """Names of fed channels of which the device cannot say whether a sensor is there."""
        return tuple(name for faults in self._faults for name in faults.open_unseen())

    def synchronisation(self, *, running: bool) -> SyncState:
        """What keeps the tasks together, and while they run how far each has counted."""
        if not running:
            return SyncState(self.synchronised_by, {}, ())
        counts = {task.plugs[0].unit: task.acquired() for task in self.tasks}
        return SyncState(self.synchronised_by, counts, tuple(n for faults in self._faults for n in faults.unlocked()))

    def _filter_delay(self, plugs: Sequence[Plug]) -> float:
        # What the rig file states as a channel's own delay is undone in the spectra, so only the rest must agree.
        delays = {
            p.channel.name: d for task in self.tasks for p, d in zip(task.plugs, task.filter_delays_s(), strict=True)
        }
        rest = [delays[plug.channel.name] - plug.channel.delay_s for plug in plugs]
        if max(rest) - min(rest) > DELAY_PART / self.rate_hz:
            listed = ", ".join(f"{name} {1e3 * delay:.4g} ms" for name, delay in delays.items())
            raise ConfigurationError(
                f"modules of different delay in one test: {listed}",
                where=f"{self._where}, rig file field channels[].input",
                remedy="connect all channels to modules of one kind, or state these delays as channels[].delay_s",
            )
        return max(delays.values())


class TriggeredRecord:
    """A started finite task that waits for a crossing."""

    def __init__(self, inputs: Inputs, trigger: ReferenceTrigger, *, virtual_time: bool) -> None:
        """Wait with `inputs`, which were made with the same trigger and started."""
        self._inputs, self._trigger, self._virtual_time = inputs, trigger, virtual_time
        self._early: NDArray[np.float32] | None = None

    def is_armed(self) -> bool:
        """Whether the pre-trigger is full."""
        if self._virtual_time and self._early is None:
            # There, time goes on only by reading.
            with suppress(BenchTimeoutError):
                self._early = self._inputs.read(self._trigger.count, 0.0)
        return self._early is not None or self._inputs.acquired() >= self._trigger.pre_trigger

    def take(self, timeout_s: float) -> NDArray[np.float32]:
        """The (channels, count) values of the record.

        Raises:
            BenchTimeoutError: no crossing yet.
        """
        early, self._early = self._early, None
        return early if early is not None else self._inputs.read(self._trigger.count, timeout_s)
