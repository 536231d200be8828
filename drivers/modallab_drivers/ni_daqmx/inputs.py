"""All inputs of a bench, from one task or from several that one clock drives."""

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.bench.abilities import ReferenceTrigger, SyncState
from modallab.core.errors import BenchTimeoutError, ConfigurationError
from modallab.core.hardware import Synchronisation
from modallab.core.units import Test
from modallab_drivers.ni_daqmx.errors import NOT_YET
from modallab_drivers.ni_daqmx.input_faults import InputFaults
from modallab_drivers.ni_daqmx.plugs import Plug
from modallab_drivers.ni_daqmx.route import Route
from modallab_drivers.ni_daqmx.synchronise import made_tasks

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
        made = made_tasks(route, plugs, test, rate_hz, reference, synchronisation or Synchronisation())
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
                remedy="wait longer; what came is kept",
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
                remedy="put all channels on modules of one kind, or state these delays as channels[].delay_s",
            )
        return max(delays.values())
