"""How tasks start, and whose clock and trigger each runs by: cards agree as far as they are wired to and no further.

Without a shared clock each card has its own rate, within some ppm; without a shared trigger each starts when its
software does; and converters that oversample begin anywhere in a sample, unless a sync pulse has aligned them.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np

from modallab_simulators.ni_daqmx_server import status
from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask, Task, terminal
from modallab_simulators.ni_daqmx_server.counter_task import CounterOutputTask, DigitalInputTask, LineTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.modules import Module
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S
from modallab_simulators.ni_daqmx_server.signals import Pulses
from modallab_simulators.ni_daqmx_server.status import StatusError
from modallab_simulators.ni_daqmx_server.systems import clock_domain, clock_error_ppm, pxi_chassis

if TYPE_CHECKING:
    from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem

SOFTWARE_S = 2e-3
"""Two starts by software are up to so long apart."""
BACKPLANE = ("PXI_CLK10", "PXIE_CLK100")
NETWORKED = ("cDAQ-9185", "cDAQ-9189")


@dataclass(slots=True)
class Clocks:
    """The clocks of a system.

    Attributes:
        several: whether there is more than one; a lone device is the bench's own clock.
        networked: chassis that keep one time over the network.
        phases: where in a sample each device's converters begin, in parts of it.
    """

    several: bool
    networked: frozenset[str]
    phases: dict[str, float] = field(default_factory=dict[str, float])
    _draw: np.random.Generator = field(default_factory=lambda: np.random.default_rng(20))

    def require_one_task(self, modules: tuple[Module, ...]) -> None:
        """Reject a task over devices that cannot be in one.

        Raises:
            StatusError: they share neither a chassis nor a backplane.
        """
        found = {clock_domain(m) for m in modules}
        if len(found) <= 1 or found <= self.networked:
            return
        backplanes = {pxi_chassis(m.name) for m in modules}
        if len(backplanes) > 1 or "" in backplanes:
            raise StatusError(status.MULTI_DEVICES, f"Devices: {', '.join(sorted(found))}")

    def ppm(self, task: Task) -> float:
        """What the rate of a task, of inputs or of outputs, is off by."""
        if not self.several:
            return 0.0
        module = task.all_channels()[0].module
        for attribute in ("SAMP_CLK_SRC", "SAMP_CLK_TIMEBASE_SRC"):
            lent = _device_of(task.full_terminal(attribute))
            if lent and lent not in _devices(task):
                return self._device_ppm(lent)
        reference = task.full_terminal("REF_CLK_SRC").rpartition("/")[2].upper()
        if reference in BACKPLANE or len({c.module.name for c in task.all_channels()}) > 1:
            return self._device_ppm(pxi_chassis(module.name) or clock_domain(module))
        lent = _device_of(task.full_terminal("REF_CLK_SRC"))
        return self._device_ppm(lent or clock_domain(module))

    def phase(self, task: InputTask) -> float:
        """Where in a sample a task begins, in parts of it."""
        if not self.several or not any(m.delta_sigma for m in task.modules):
            return 0.0
        own = clock_domain(task.modules[0])
        lent = _device_of(task.full_terminal("SYNC_PULSE_SRC"))
        locked = bool(task.get("REF_CLK_SRC") or task.get("SAMP_CLK_TIMEBASE_SRC"))
        if lent and locked and lent in self.phases:
            self.phases[own] = self.phases[lent]
        else:
            self.phases[own] = float(self._draw.uniform())
        return self.phases[own]

    def software_s(self) -> float:
        """How much later than asked for a start by software is."""
        return float(self._draw.uniform(0.0, SOFTWARE_S)) if self.several else 0.0

    def _device_ppm(self, device: str) -> float:
        name = "network" if device in self.networked else device
        return clock_error_ppm(crc32(name.encode()))


def _device_of(source: str) -> str:
    return source.split("/")[1] if source.startswith("/") and source.count("/") > 1 else ""


def _devices(task: Task) -> set[str]:
    return {name for channel in task.all_channels() for name in (channel.module.name, channel.module.chassis)}


DIGITAL_EDGE, FALLING = 10150, 10171
_OWN = ("OnboardClock", "SampleClockTimebase")
Moment = tuple[float, float]


def start(system: "SimulatedSystem", task: Task) -> None:
    """Start a task, and all that have waited for it."""
    task.running = task.waiting = True
    task.runs += 1
    if not _go(system, task, None):
        _follow_reference(system, task)
        return
    settle(system, task)


def settle(system: "SimulatedSystem", begun: Task | None) -> None:
    """Let tasks go whose trigger or clock has come, with what follows from that."""
    for task in [t for t in system.tasks.values() if t.running and t.waiting]:
        if _go(system, task, begun):
            settle(system, task)


def _go(system: "SimulatedSystem", task: Task, begun: Task | None) -> bool:
    moment = _moment(system, task, begun)
    if moment is None:
        return False
    at_s, rate_hz = moment
    task.waiting = False
    if isinstance(task, InputTask):
        system.sample(task, at_s, rate_hz)
        _follow_reference(system, task)
    elif isinstance(task, AcquiringTask):
        task.begin(at_s, rate_hz or task.rate_hz)
    elif isinstance(task, OutputTask):
        triggered = _trigger(task) or _external_clock(task)
        for output in (task, *task.others):
            output.ppm = system.clocks.ppm(task)
            output.start(system.clock, at_s if triggered else None)
        system.changed()
    elif isinstance(task, LineTask | CounterOutputTask):
        task.start_s = at_s + (LATENCY_S if isinstance(task, CounterOutputTask) else 0.0)
    return True


def _moment(system: "SimulatedSystem", task: Task, begun: Task | None) -> Moment | None:
    """When a task begins, and the rate of a clock that is not its own; None: not yet."""
    now_s = system.clock.now()
    source = _trigger(task)
    at_s: float | None = now_s
    if isinstance(task, InputTask) and not source:
        at_s = now_s + system.clocks.software_s()
    if source:
        at_s = _edge(system, source, now_s, begun, rising=task.get("DIG_EDGE_START_TRIG_EDGE") != FALLING)
    if at_s is None:
        return None
    clock = _external_clock(task)
    if not clock:
        return at_s, 0.0
    pulses = system.pulses(clock)
    if pulses is None:
        return None
    first = pulses.edge_after(at_s, rising=task.get("SAMP_CLK_ACTIVE_EDGE") != FALLING)
    return None if first is None else (first, pulses.frequency_hz)


def _trigger(task: Task) -> str:
    return task.full_terminal("DIG_EDGE_START_TRIG_SRC") if task.get("START_TRIG_TYPE") == DIGITAL_EDGE else ""


def _external_clock(task: Task) -> str:
    source = task.full_terminal("SAMP_CLK_SRC")
    return "" if not source or source.endswith(_OWN) or task.timing != "clocked" else source


def _edge(system: "SimulatedSystem", source: str, at_s: float, begun: Task | None, *, rising: bool) -> float | None:
    if begun is not None and route(source) in start_terminals(begun):
        return start_time(begun, system.clock.now())
    pulses = system.pulses(source)
    return None if pulses is None else pulses.edge_after(at_s, rising=rising)


def start_time(task: Task, now_s: float) -> float:
    """Bench time at which a task began."""
    if isinstance(task, AcquiringTask):
        return task.triggered_s
    if isinstance(task, LineTask | CounterOutputTask):
        return task.start_s
    return task.wave.start_s if isinstance(task, OutputTask) and task.wave is not None else now_s


def kind_of(task: Task) -> str:
    """Subsystem of a task, as its terminals name it."""
    if isinstance(task, InputTask):
        return "ai"
    if isinstance(task, OutputTask):
        return "ao"
    return "di" if isinstance(task, DigitalInputTask) else "do" if isinstance(task, LineTask) else ""


def route(source: str) -> str:
    """A terminal, where the trigger lines of a backplane are the same for all its cards."""
    last = source.rpartition("/")[2]
    if last.upper().startswith("PXI_TRIG") and source.startswith("/PXI"):
        return f"{source[1:].partition('Slot')[0]}/{last.upper()}"
    return source


def start_terminals(task: Task) -> set[str]:
    """Where the start trigger of a task can be found."""
    devices = {c.module.name for c in task.all_channels()} | {task.default_device}
    own = {f"/{device}/{kind_of(task)}/StartTrigger" for device in devices}
    exported = task.full_terminal("START_TRIG_OUTPUT_TERM")
    return own | ({route(exported)} if exported else set())


def clock_pulses(task: Task) -> Pulses | None:
    """The sample clock of a task that runs."""
    if isinstance(task, AcquiringTask) and task.running and not task.waiting and task.timing == "clocked":
        return Pulses(task.start_s, task.true_hz, count=task.finite or float("inf"))
    if isinstance(task, OutputTask) and task.wave is not None:
        return Pulses(task.wave.start_s, task.rate_hz)
    if isinstance(task, LineTask) and task.running and not task.waiting and task.rate_hz:
        return Pulses(task.start_s, task.rate_hz, count=task.finite or float("inf"))
    return None


def pulses_of(task: Task, source: str) -> Pulses | None:
    """What a task puts on a terminal; None if that is nothing."""
    if isinstance(task, CounterOutputTask):
        for channel in task.channels:
            number = channel.physical.rpartition("ctr")[2]
            device = channel.module.chassis or channel.module.name
            own = terminal(str(task.get("CO_PULSE_TERM", f"PFI{12 + int(number)}", channel.name)), device)
            if source in (f"/{channel.module.name}/Ctr{number}InternalOutput", own):
                return task.pulses(channel)
        return None
    kind = kind_of(task)
    ends = {
        f"/{device}/{kind}/SampleClock"
        for device in {c.module.name for c in task.all_channels()} | {task.default_device}
    }
    exported = task.full_terminal("SAMP_CLK_OUTPUT_TERM")
    clocks = ends | ({route(exported)} if exported else set())
    return clock_pulses(task) if kind and route(source) in clocks else None


def _follow_reference(system: "SimulatedSystem", task: Task) -> None:
    """When the digital edge comes that a reference trigger waits for."""
    if not isinstance(task, InputTask) or task.trigger is None or task.trigger.channel >= 0 or task.waiting:
        return
    pulses = system.pulses(task.full_terminal("DIG_EDGE_REF_TRIG_SRC"))
    full_s = task.start_s + task.trigger.pre_trigger / task.true_hz
    rising = task.get("DIG_EDGE_REF_TRIG_EDGE") != FALLING
    task.trigger_s = None if pulses is None else pulses.edge_after(full_s, rising=rising)
