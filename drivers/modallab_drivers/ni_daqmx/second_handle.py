"""A second handle to the output, for whoever must end an excitation that its owner no longer can."""

from contextlib import suppress
from typing import Any

import nidaqmx.errors

from modallab.core.errors import BenchError, DeviceBusyError
from modallab.core.rig import Rig
from modallab_drivers.function_generator.generator import emergency_off
from modallab_drivers.ni_daqmx.analog_output import task_name
from modallab_drivers.ni_daqmx.errors import WatchdogExpiredError, typed_errors
from modallab_drivers.ni_daqmx.guards import heartbeat_name, watchdog_name
from modallab_drivers.ni_daqmx.plugs import outputs_of
from modallab_drivers.ni_daqmx.ramp_down import ramp_down_to_zero, write_zero
from modallab_drivers.ni_daqmx.route import ZERO_WAIT_S, Route, parse_address, retry_while_reserved
from modallab_drivers.ni_daqmx.synchronise import session_name


class SecondHandle:
    """Brings the output to 0 V, from another process than the one that drives.

    All that can be made ready is: a burst whose task cannot be reached is ended by two calls.
    """

    def __init__(self, url: str, rig: Rig) -> None:
        """Find the output; nothing is reserved.

        Raises:
            BenchError: no such device or output.
        """
        self._route = Route(parse_address(url))
        self._rig = rig
        self._where = url
        self._outputs = dict(outputs_of(rig, self._route.devices(), url))
        self._physical = tuple(self._outputs)
        self._ready: Any = self._made()

    def zero(self) -> None:
        """End what plays on the outputs, whoever started it, and put 0 V on all of them.

        Raises:
            BenchError: it could not be done, by no way.
        """
        excitation = self._rig.excitation
        if excitation is not None and excitation.kind == "generator":
            emergency_off(excitation)
        if not self._physical:
            return
        failed: BenchError | None = None
        for way in (self._end, self._end_anew, self._end_by_reset):
            if way == self._end_anew and isinstance(failed, DeviceBusyError) and self._route.address.streams:
                # A process that holds the output for so long is frozen or drives on: to ask again is time lost.
                continue
            try:
                way()
            except WatchdogExpiredError:
                # The device holds it at 0 V, and whoever drives next resets the chassis.
                return
            except BenchError as error:
                failed = error
            else:
                return
        assert failed is not None
        raise failed

    def _end(self) -> None:
        self._fall()
        self._end_task(task_name(self._physical[0]))
        # Its owner, or another handle, may be bringing it to 0 V at this moment: no reason to reset the device.
        retry_while_reserved(self._write_zero, ZERO_WAIT_S)

    def _fall(self) -> None:
        """Ahead of the step: where the server keeps the burst's task, it falls from the value it has."""
        if self._route.remote:
            # Whatever goes wrong with a fall, the step must come.
            with suppress(Exception):
                ramp_down_to_zero(self._ready._interpreter, self._named(task_name(self._physical[0])), self._physical)

    def _end_anew(self) -> None:
        # Our own task may be gone, when the device was reset or came back.
        self._ready = self._made()
        self._end()

    def _end_by_reset(self) -> None:
        # Whoever holds it is no task of ours: the device lets go of everything.
        with typed_errors(self._where):
            for device in dict.fromkeys(physical.partition("/")[0] for physical in self._physical):
                self._route.device(device).reset_device()
        self._end_anew()

    def release(self) -> None:
        """Give back what a client that died still holds on the server.

        Raises:
            BenchError: the output could not be brought to 0 V first.
        """
        self.zero()
        for device in (self._route.address.device, *self._route.address.others):
            self._end_task(session_name(device))
            self._end_task(watchdog_name(device))
            self._end_task(heartbeat_name(device))

    def close(self) -> None:
        """Let go."""
        with suppress(nidaqmx.errors.Error):
            self._ready.close()
        self._route.close()

    def _made(self) -> Any:
        with typed_errors(self._where):
            task = self._route.task()
            for physical, range_v in self._outputs.items():
                task.ao_channels.add_ao_voltage_chan(physical, min_val=-range_v, max_val=range_v)
            return task

    def _end_task(self, name: str) -> None:
        if not self._route.remote:
            return
        with suppress(nidaqmx.errors.DaqError):
            self._ready._interpreter.clear_task(self._named(name))

    def _named(self, name: str) -> Any:
        # The session itself by its name, not our share of it, and without asking about it first.
        return type(self._ready._handle)(name=name)

    def _write_zero(self) -> None:
        ready = self._ready
        with typed_errors(self._where):
            try:
                write_zero(ready._interpreter, ready._handle, len(self._outputs))
            finally:
                # Not to hold it a moment longer than needed, whatever came of it.
                with suppress(nidaqmx.errors.DaqError):
                    ready.stop()
