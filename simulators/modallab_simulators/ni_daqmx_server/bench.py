"""The simulated system: its devices, the tasks on them, the plant behind them, and what an operator does to it."""

import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from modallab.core.rig import Rig
from modallab_simulators import faults
from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.clock import BenchClock
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.lines import Hold, OutputLine
from modallab_simulators.ni_daqmx_server.modules import CHASSIS, Module
from modallab_simulators.ni_daqmx_server.output_task import LineTask, OutputTask, WatchdogTask
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S, Plant
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.supply import Supplies
from modallab_simulators.ni_daqmx_server.tasks import Reservations, Task

T = TypeVar("T", bound=Task)

LOOK_S = 0.005


class SimulatedSystem:
    """Everything a server holds. It outlives its clients: what they started goes on when they die.

    Attributes:
        lock: taken by whoever looks or changes.
        clock: of the bench.
        modules: devices by name.
        chassis: product type of the chassis, or "".
        plant: behind inputs and outputs.
        rig: what truly stands there.
        lines: analog outputs by physical channel.
        tasks: by name.
        faults: armed.
        expired: whether the chassis' watchdog has expired: nothing goes on it until the chassis is reset.
    """

    def __init__(self, clock: BenchClock, chassis: str, modules: tuple[Module, ...], plant: Plant, rig: Rig) -> None:
        self.lock = threading.RLock()
        self.clock = clock
        self.chassis = chassis
        self.modules = {module.name: module for module in modules}
        self.plant = plant
        self.rig = rig
        self.lines = {name: OutputLine() for module in modules for name in module.output_names()}
        self.generator_line: OutputLine | None = None
        self.tasks: dict[str, Task] = {}
        self.reserved = Reservations()
        self.supplies = Supplies()
        self.faults = faults.FaultPlan()
        self.reset_keeps_outputs = False
        self.expired = False
        self._numbers = 0

    @property
    def shaker_line(self) -> OutputLine:
        """The line the shaker's amplifier hangs on."""
        if self.generator_line is not None:
            return self.generator_line
        return next(iter(self.lines.values()), OutputLine())

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
        if isinstance(task, InputTask):
            task.supplies = self.supplies
            self.supplies.switch_on(task.fed, self.clock.now())
            task.start(self.plant, self.shaker_line, self.clock)
        elif isinstance(task, OutputTask):
            task.start(self.clock)
            self.changed()
        else:
            task.running = True
            if isinstance(task, WatchdogTask):
                task.kick(time.monotonic())

    def require_unexpired(self, task: Task) -> None:
        """Raise if the chassis' watchdog has expired.

        Raises:
            StatusError: it has.
        """
        if self.expired:
            raise StatusError(status.CHASSIS_EXPIRED, f"Task Name: {task.name}")

    def _require_alone(self, watchdog: WatchdogTask) -> None:
        # The vendor's order: a watchdog before any other task on its chassis.
        others = [t.name for t in self.tasks.values() if t is not watchdog and (t.running or t.committed)]
        if others:
            raise StatusError(status.OTHERS_RESERVED, f"Task Name: {watchdog.name}\nOther tasks: {', '.join(others)}")

    def stop(self, task: Task) -> None:
        """Stop a task and give back what it held."""
        if isinstance(task, OutputTask):
            task.stop(self.clock)
            self.changed()
        task.running = False
        if isinstance(task, InputTask) and not task.committed:
            self.supplies.switch_off(task.fed)
        if not task.committed:
            self.reserved.release(task)

    def clear(self, name: str) -> None:
        """Stop a task and forget it."""
        task = self.tasks.pop(name, None)
        if task is None:
            raise StatusError(status.INVALID_TASK, f"Task Name: {name}")
        task.committed = False
        self.stop(task)

    def reset(self, device: str) -> None:
        """Abort all tasks of a device; most series then have their outputs at 0 V, some leave them."""
        if device not in self.modules and device != CHASSIS:
            raise StatusError(status.NO_SUCH_DEVICE, f"Device Specified: {device}")
        if self.expired and device != CHASSIS:
            raise StatusError(status.CHASSIS_EXPIRED, f"Device: {device}")
        self.expired = False
        hit = {m for m in self.modules if m == device or device == CHASSIS}
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
        task.expired = self.expired = True
        for name, volts in task.states.items():
            self.lines[name].expire(self.clock.now() + LATENCY_S, volts)
        self.changed()

    def fault(self, line: str) -> None:
        """Arm a fault, as an operator types it: `unplugged -201003`, `status ReadAnalogF64 -200279 2`.

        Raises:
            ValueError: the simulated devices cannot have it.
        """
        kind, words = faults.parse(line, faults.DAQ_FAULTS)
        arguments: dict[str, Any] = {
            faults.SAMPLES_LOST: ("ReadAnalogF64", status.NO_LONGER_AVAILABLE),
            faults.TIME_OUT: ("ReadAnalogF64", 0),
            faults.PARTIAL: ("ReadAnalogF64", 0),
            faults.WARNING: ("ReadAnalogF64", 0),
        }
        if kind in arguments:
            call, code = arguments[kind]
            self.faults.arm(faults.Armed(call, code, kind, int(words[0]) if words else 1))
        elif kind == faults.STATUS:
            self.faults.arm(faults.Armed(words[0], int(words[1]), kind, int(words[2]) if len(words) > 2 else 1))
        else:
            self._break(kind, words)

    def _break(  # a table of faults reads as one
        self, kind: str, words: list[str]
    ) -> None:
        inputs = [task for task in self.tasks.values() if isinstance(task, InputTask)]
        if kind == faults.UNPLUGGED:
            code = int(words[0]) if words else status.DEVICE_GONE
            self.reserved.gone = dict.fromkeys([*self.modules, CHASSIS], code)
            for task in self.tasks.values():
                if isinstance(task, OutputTask):
                    # The samples came through the cable, which no server changes.
                    task.starve(self.clock)
        elif kind == faults.PLUGGED:
            # A device that comes back has forgotten its tasks.
            self.reserved.gone = {}
            self._forget(list(self.tasks.values()))
        elif kind == faults.RESERVED:
            self.reserved.hold(words[0], words[1] if len(words) > 1 else "another program")
        elif kind == faults.RELEASED:
            self.reserved.drop(words[0])
        elif kind == faults.INVALID:
            self._forget(inputs)
        elif kind == faults.DEAD_LINE:
            for task in inputs:
                task.dead.add(int(words[0]))

    def _forget(self, tasks: Sequence[Task]) -> None:
        for task in tasks:
            self.clear(task.name)

    def trace(self, over_s: float, rate_hz: float) -> list[float]:
        """What stood on the shaker's line over the last `over_s`, oldest first."""
        now = self.clock.now()
        return self.shaker_line.volts(now - np.arange(round(over_s * rate_hz))[::-1] / rate_hz).tolist()

    def levels(self, over_s: float = 0.05) -> dict[str, float]:
        """Largest magnitude on every output over the last `over_s`, and the lines' last changes."""
        now = self.clock.now()
        times = np.linspace(now - over_s, now, 500)
        lines = dict(self.lines)
        if self.generator_line is not None:
            lines["generator"] = self.generator_line
        found = {name: float(np.abs(line.volts(times)).max()) for name, line in lines.items()}
        for task in self.tasks.values():
            if isinstance(task, LineTask):
                found |= {f"{name} changes": float(task.changes) for name in task.lines}
        return found
