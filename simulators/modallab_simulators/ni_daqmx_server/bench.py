"""The simulated system: its devices, the tasks on them, the plant behind them, and what an operator does to it."""

import threading
import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

from modallab.core.rig import Rig
from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import Reservations, Task
from modallab_simulators.ni_daqmx_server.counter_task import LineTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.lines import Hold, OutputLine
from modallab_simulators.ni_daqmx_server.max_config import SavedConfiguration
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.output_task import OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S, Plant, SharedPlant
from modallab_simulators.ni_daqmx_server.signals import TIMEBASES, BenchClock, Pulses
from modallab_simulators.ni_daqmx_server.sources import channel_sources
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import Layout, clock_domain
from modallab_simulators.ni_daqmx_server.task_start import NETWORKED, Clocks, pulses_of, start

T = TypeVar("T", bound=Task)

LOOK_S = 0.005


class SimulatedSystem:
    """Everything a server holds. It outlives its clients: what they started goes on when they die.

    Attributes:
        lock: taken by whoever looks or changes.
        clock: of the bench.
        modules: devices by name.
        chassis: chassis that are devices of their own, by name.
        clocks: whose rate and phase each task has.
        saved: scales, channels and tasks that the system keeps.
        connected: what an operator has connected to terminals.
        levels_of_lines: what was last put on digital lines.
        sheets: electronic data sheets that were assigned to channels.
        notes: of those who calibrate, by device.
        excited: since when IEPE excitation is on, by physical channel.
        plant: behind inputs and outputs.
        rig: what truly stands there.
        lines: analog outputs by physical channel.
        tasks: by name.
        faults: armed.
        expired: chassis whose watchdog has expired: nothing goes on them until they are reset.
    """

    def __init__(
        self, clock: BenchClock, layout: Layout, plant: Plant, rig: Rig, saved: SavedConfiguration | None = None
    ) -> None:
        self.lock = threading.RLock()
        self.clock = clock
        self.chassis = {chassis.name: chassis for chassis in layout.chassis}
        self.modules = {module.name: module for module in layout.modules}
        several = len({clock_domain(m) for m in layout.modules if m.inputs and not m.simulated}) > 1
        networked = frozenset(c.name for c in layout.chassis if c.product in NETWORKED)
        self.clocks = Clocks(several, networked)
        self.plant: Plant = SharedPlant(plant) if several else plant
        self.rig = rig
        self.saved = saved or SavedConfiguration()
        self.connected: dict[str, Pulses] = {}
        self.sheets: dict[str, bytes] = {}
        self.notes: dict[str, str] = {}
        self.levels_of_lines: dict[str, bool] = {}
        self.excited: dict[str, float] = {}
        self.lines = {name: OutputLine() for module in layout.modules for name in module.output_names()}
        self.generator_line: OutputLine | None = None
        self.tasks: dict[str, Task] = {}
        self.reserved = Reservations()
        self.faults = faults.FaultPlan()
        self.reset_keeps_outputs = False
        self.expired: set[str] = set()
        self._numbers = 0

    @property
    def shaker_line(self) -> OutputLine:
        """The line the first shaker's amplifier hangs on."""
        return self.shaker_lines[0]

    @property
    def shaker_lines(self) -> tuple[OutputLine, ...]:
        """The line each shaker's amplifier hangs on: the first outputs, in order, with one shaker at least."""
        if self.generator_line is not None:
            return (self.generator_line,)
        return tuple(self.lines.values())[: max(1, len(self.rig.shaker_points))] or (OutputLine(),)

    def inputs(self) -> Iterator[tuple[str, Module]]:
        """All physical input channels, in order."""
        for module in self.modules.values():
            for name in module.input_names():
                yield name, module

    def module_of(self, physical: str) -> Module:
        """The module of a physical channel.

        Raises:
            StatusError: there is no such device.
        """
        name = physical.partition("/")[0]
        if name not in self.modules:
            raise StatusError(status.NO_SUCH_DEVICE, f"Device Specified: {name}")
        return self.modules[name]

    def require_device(self, name: str) -> None:
        """Reject the name of what is neither a device nor a chassis, or is gone.

        Raises:
            StatusError: there is no such device.
        """
        if name in self.reserved.gone:
            raise StatusError(self.reserved.gone[name], f"Device: {name}")
        if name not in self.chassis:
            self.module_of(name)

    def row_of(self, physical: str) -> int:
        """The rig's channel that is plugged into a physical channel: the one that names it, or the one in order."""
        names = [name for name, _ in self.inputs()]
        named = [channel.index for channel in self.rig.channels if channel.input == physical]
        if named:
            return named[0]
        place = names.index(physical)
        # Inputs nobody is plugged into hang on the last sensor's cable.
        return min(place, len(self.rig.channels) - 1)

    def add(self, task: Task) -> Task:
        """Take up a task under its name."""
        self.tasks[task.name] = task
        return task

    def free_name(self) -> str:
        """A name nobody uses."""
        self._numbers += 1
        return f"_unnamedTask<{self._numbers:X}>"

    def task(self, name: str, kind: type[T]) -> T:
        """A task of a kind.

        Raises:
            StatusError: there is none, or its device is gone.
        """
        task = self.tasks.get(name)
        if task is None:
            raise StatusError(status.INVALID_TASK, f"Task Name: {name}")
        self.reserved.require_present(task)
        if not isinstance(task, kind):
            raise StatusError(status.NOT_SUPPORTED_HERE, f"Task Name: {name}")
        return task

    def start(self, task: Task) -> None:
        """Start a task: reserve, then run."""
        self.require_unexpired(task)
        if isinstance(task, WatchdogTask):
            self._require_alone(task)
        self.reserved.take(task)
        if isinstance(task, WatchdogTask):
            task.running = True
            task.kick(time.monotonic())
        else:
            self._start(task)

    def _start(self, task: Task) -> None:
        try:
            start(self, task)
        except StatusError:
            self.stop(task)
            raise

    def require_unexpired(self, task: Task) -> None:
        """Raise if the watchdog of the task's chassis has expired.

        Raises:
            StatusError: it has.
        """
        if self.expired and self._chassis_of(task) & self.expired:
            raise StatusError(status.CHASSIS_EXPIRED, f"Task Name: {task.name}")

    def _chassis_of(self, task: Task) -> set[str]:
        if isinstance(task, WatchdogTask):
            return {task.device}
        return {self.modules[name].chassis for name in task.devices if name in self.modules} - {""}

    def _require_alone(self, watchdog: WatchdogTask) -> None:
        # The vendor's order: a watchdog before any other task on its chassis.
        others = [
            t.name
            for t in self.tasks.values()
            if t is not watchdog and (t.running or t.kept) and watchdog.device in self._chassis_of(t)
        ]
        if others:
            raise StatusError(status.OTHERS_RESERVED, f"Task Name: {watchdog.name}\nOther tasks: {', '.join(others)}")

    def sample(self, task: InputTask, at_s: float, rate_hz: float) -> None:
        """Let an input task sample from a bench time on; `rate_hz` is that of a clock it was given, or 0."""
        true_hz = (rate_hz or task.rate_hz) * (1 + self.clocks.ppm(task) * 1e-6)
        first_s = at_s if rate_hz else at_s + self.clocks.phase(task) / true_hz
        task.sample(first_s, true_hz, lambda hz, from_s: channel_sources(self, task, hz, from_s))
        task.triggered_s = at_s

    def pulses(self, source: str) -> Pulses | None:
        """What is on a terminal now."""
        if source in self.connected:
            return self.connected[source]
        last = source.rpartition("/")[2]
        if last in TIMEBASES:
            return Pulses(0.0, TIMEBASES[last])
        for task in self.tasks.values():
            found = pulses_of(task, source)
            if found is not None:
                return found
        return None

    def level(self, line: str, at_s: float) -> bool:
        """What stands on a digital line at a bench time."""
        for task in self.tasks.values():
            if isinstance(task, LineTask) and task.running and line in task.lines:
                return task.level(line, at_s)
        return self.levels_of_lines.get(line, False)

    def stop(self, task: Task) -> None:
        """Stop a task and give back what it held."""
        if isinstance(task, OutputTask):
            for output in (task, *task.others):
                output.stop(self.clock)
            self.changed()
        elif isinstance(task, LineTask):
            task.stop()
        elif isinstance(task, WatchdogTask) and task.device not in self.expired:
            self.resume_outputs(task)
        task.running = task.waiting = False
        if not task.kept:
            self.reserved.release(task)

    def clear(self, name: str) -> None:
        """Stop a task and forget it."""
        task = self.tasks.pop(name, None)
        if task is None:
            raise StatusError(status.INVALID_TASK, f"Task Name: {name}")
        task.kept = False
        self.stop(task)

    def reset(self, device: str) -> None:
        """Abort all tasks of a device; most series then have their outputs at 0 V, some leave them."""
        if device not in self.modules and device not in self.chassis:
            raise StatusError(status.NO_SUCH_DEVICE, f"Device Specified: {device}")
        if device in self.modules and self.modules[device].chassis in self.expired:
            raise StatusError(status.CHASSIS_EXPIRED, f"Device: {device}")
        self.expired.discard(device)
        hit = {name for name, module in self.modules.items() if device in (name, module.chassis)}
        self.excited = {name: at_s for name, at_s in self.excited.items() if name.partition("/")[0] not in hit}
        for task in [t for t in self.tasks.values() if t.devices & hit]:
            self.clear(task.name)
        for watchdog in [t for t in self.tasks.values() if isinstance(t, WatchdogTask) and t.device == device]:
            self.clear(watchdog.name)
        for name, line in self.lines.items():
            if name.partition("/")[0] in hit and not self.reset_keeps_outputs:
                line.held = False
                line.put(self.clock.now() + LATENCY_S, Hold(0.0))
        self.changed()

    def changed(self) -> None:
        """An output is another than it was: what was computed ahead is not true any more."""
        for task in self.tasks.values():
            if isinstance(task, InputTask) and task.source is not None:
                task.source.changed()

    def watch(self) -> None:
        """Look after the watchdogs, for ever."""
        while True:
            time.sleep(LOOK_S)
            with self.lock:
                for task in self.tasks.values():
                    if isinstance(task, WatchdogTask) and task.running and not task.expired:
                        self._look_at(task)

    def _look_at(self, task: WatchdogTask) -> None:
        if time.monotonic() < task.due_s:
            return
        task.expired = True
        if task.device in self.chassis:
            self.expired.add(task.device)
        for name, volts in task.states.items():
            self.lines[name].expire(self.clock.now() + LATENCY_S, volts)
        self.changed()

    def resume_outputs(self, watchdog: WatchdogTask) -> None:
        """The outputs of a watchdog that is cleared, stopped or started again follow their tasks again."""
        watchdog.expired = False
        for name in watchdog.states:
            self.lines[name].held = False

    def forget(self, tasks: Sequence[Task]) -> None:
        """Clear tasks."""
        for task in tasks:
            self.clear(task.name)
