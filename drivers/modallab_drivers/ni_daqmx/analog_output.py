"""Shakers on analog outputs: finite bursts that end at exactly 0 V by themselves, or by a fall when stopped."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import nidaqmx.errors
import numpy as np
from nidaqmx.constants import AcquisitionType, AOIdleOutputBehavior, RegenerationMode, TaskMode
from numpy.typing import NDArray

from modallab.bench.protocol import Burst, Waveform
from modallab.core.errors import BenchError, OutputLostError
from modallab_drivers.ni_daqmx.errors import WatchdogExpiredError, typed_error, typed_errors
from modallab_drivers.ni_daqmx.guards import call_after_reset
from modallab_drivers.ni_daqmx.ramp_down import DESCRIPTION, IDLE, TaskSignal, TaskWave, ramp_down_to_zero, write_zero
from modallab_drivers.ni_daqmx.route import ZERO_WAIT_S, Route, retry_while_reserved
from modallab_drivers.ni_daqmx.synchronise import REFERENCE_CLOCKS
from modallab_drivers.output import burst_samples, wave_samples

MIN_RATE_HZ = 5000.0
SAMPLES_A_CYCLE = 25.0


def task_name(physical: str) -> str:
    """Name under which a server knows the task of outputs, by the first of them: so a second handle finds it."""
    return f"modallab-{physical.replace('/', '-')}"


class AnalogOutput:
    """The analog outputs of a rig's shakers, in one task while something plays; else they are at a plain 0 V.

    They start at one sample, end at one, and are stopped together: those that nothing is played on play 0 V.

    Attributes:
        reference_clock: of the backplane, which they are to follow; empty: their device's own clock.
    """

    def __init__(self, route: Route, outputs: Sequence[tuple[str, float]], *, guarded: bool = True) -> None:
        """Take the outputs and bring them to 0 V.

        Args:
            route: to the device.
            outputs: of each shaker, the first one's first, and the largest amplitude it can give.
            guarded: whether something else brings them to 0 V should this process or machine die.

        Raises:
            DeviceBusyError: another program holds one.
        """
        self._route, self._outputs = route, dict(outputs)
        self._physical = tuple(self._outputs)
        self._where = f"{route.address.url}, output {', '.join(self._physical)}"
        self._task: Any = None
        self._waves: NDArray[np.float64] = np.zeros((len(outputs), 1))
        self._played: list[TaskSignal | TaskWave] = []
        self.reference_clock = ""
        # After a death 0 V is better than the last value. A stop in good order needs the last value, for its fall.
        behaviour = AOIdleOutputBehavior
        self._idle = behaviour.MAINTAIN_EXISTING_VALUE if guarded else behaviour.ZERO_VOLTS
        retry_while_reserved(lambda: call_after_reset(route, self._write_zero))

    @property
    def range_v(self) -> float:
        """The largest amplitude each can give."""
        return min(self._outputs.values())

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self._physical)

    @property
    def busy(self) -> bool:
        """Whether a burst is on."""
        return self._task is not None and not self._done()

    def play(self, burst: Burst, now: int, rate_hz: float) -> None:
        """Write the whole burst to the first output and start it: from here on it ends without us."""
        requested = max(MIN_RATE_HZ, SAMPLES_A_CYCLE * burst.frequency_hz)
        self._start(requested, lambda rate: [burst_samples(burst, rate)], lambda rate, _: [TaskSignal(burst, rate)])

    def play_waves(self, waves: Sequence[Waveform]) -> None:
        """Write whole waves of one rate and length to the outputs and start them: from here on they end without us."""
        self._start(
            waves[0].rate_hz,
            lambda rate: [wave_samples(wave, rate) for wave in waves],
            lambda rate, rows: [TaskWave.kept(row, rate) for row in rows],
        )

    def _start(
        self,
        requested: float,
        samples_at: Callable[[float], list[NDArray[np.float64]]],
        played_at: Callable[[float, list[NDArray[np.float64]]], Sequence[TaskSignal | TaskWave]],
    ) -> None:
        self._drop()
        with typed_errors(self._where):
            task = retry_while_reserved(lambda: self._new(task_name(self._physical[0])))
            try:
                count = len(samples_at(requested)[0])
                task.timing.cfg_samp_clk_timing(requested, sample_mode=AcquisitionType.FINITE, samps_per_chan=count)
                self._follow(task)
                rate = float(task.timing.samp_clk_rate)
                rows = samples_at(rate)
                if len(rows[0]) != count:
                    task.timing.cfg_samp_clk_timing(
                        requested, sample_mode=AcquisitionType.FINITE, samps_per_chan=len(rows[0])
                    )
                task.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
                self._played = list(played_at(rate, rows))
                zeros = [TaskSignal.zeros(len(rows[0]), rate)] * (self.count - len(rows))
                self._describe(task, [played.described() for played in (*self._played, *zeros)])
                waves = np.zeros((self.count, len(rows[0])))
                waves[: len(rows)] = rows
                # The package wants one row where there is one output.
                task.write(waves if self.count > 1 else waves[0], auto_start=False)
                # Committed, so that a stop keeps the output and the count of what was generated.
                task.control(TaskMode.TASK_COMMIT)
                task.start()
            except BaseException:
                self._forget()
                task.close()
                raise
        self._task, self._waves = task, waves

    def next_event(self) -> int | None:
        """A burst needs nothing while it is on."""
        return None

    def tick(self, now: int) -> None:
        """See whether the burst goes on as it should, and let go of it at its end.

        Raises:
            OutputLostError: the device ran out of samples; the output is at 0 V.
        """
        if self._task is None:
            return
        try:
            with typed_errors(self._where):
                done = self._task.is_task_done()
        except OutputLostError:
            self.zero()
            raise
        if done:
            self._drop()

    def zero(self) -> None:
        """End what plays and put 0 V on all outputs.

        A stopped output holds its last value, so it falls from there, and 0 V is written after that in any case.
        """
        if self._task is not None:
            # Where the device does not answer, or nobody knows what the output has come to, only a step is left.
            with suppress(Exception):
                rate_hz = float(self._task.timing.samp_clk_rate)
                ramp_down_to_zero(self._task._interpreter, self._task._handle, self._physical, (self._waves, rate_hz))
        self._drop()
        # A supervisor may be doing the same at this moment, and holds the output meanwhile.
        # And an expired watchdog holds it at 0 V.
        with suppress(WatchdogExpiredError):
            retry_while_reserved(self._write_zero, ZERO_WAIT_S)

    def close(self) -> None:
        """Bring it to 0 V and let go of it."""
        self.zero()

    def abandon(self) -> None:
        """Forget the task of a device that is gone."""
        self._task = None
        self._forget()

    def _forget(self) -> None:
        all_played, self._played = self._played, []
        for played in all_played:
            if isinstance(played, TaskWave):
                played.forget()

    def _write_zero(self) -> None:
        task = self._new("")
        try:
            with typed_errors(self._where):
                write_zero(task._interpreter, task._handle, self.count)
        finally:
            task.close()

    def _done(self) -> bool:
        try:
            with typed_errors(self._where):
                return bool(self._task.is_task_done())
        except OutputLostError:
            return True

    def _new(self, name: str) -> Any:
        with typed_errors(self._where):
            task = self._route.task(name)
            try:
                for physical, range_v in self._outputs.items():
                    task.ao_channels.add_ao_voltage_chan(physical, min_val=-range_v, max_val=range_v)
            except BaseException:
                task.close()
                raise
            return task

    def _follow(self, task: Any) -> None:
        if not self.reference_clock:
            return
        task.timing.ref_clk_src = self.reference_clock
        task.timing.ref_clk_rate = REFERENCE_CLOCKS.get(self.reference_clock, 10e6)
        try:
            task.control(TaskMode.TASK_VERIFY)
        except nidaqmx.errors.DaqError:
            # An output outside the chassis, or one that cannot: by its own clock, as on every bench of one device.
            del task.timing.ref_clk_src

    def _describe(self, task: Any, described: Sequence[str]) -> None:
        interpreter, handle = task._interpreter, task._handle
        for physical, text in zip(self._physical, described, strict=True):
            interpreter.set_chan_attribute_string(handle, physical, DESCRIPTION, text)
            with suppress(nidaqmx.errors.DaqError):
                # Few devices have it.
                interpreter.set_chan_attribute_int32(handle, physical, IDLE, self._idle.value)

    def _drop(self) -> None:
        task, self._task = self._task, None
        self._forget()
        if task is None:
            return
        try:
            with suppress(nidaqmx.errors.DaqError):
                task.stop()
            task.close()
        except nidaqmx.errors.Error as error:
            found = typed_error(error, self._where)
            if not isinstance(found, BenchError) or found.code == "bench-gone":
                raise found from error
