"""How tasks start: at once, or when their trigger and their clock come."""

from typing import TYPE_CHECKING

from modallab_simulators.ni_daqmx_server.acquisition import AcquiringTask
from modallab_simulators.ni_daqmx_server.counter_task import CounterOutputTask
from modallab_simulators.ni_daqmx_server.digital_task import DigitalInputTask, LineTask
from modallab_simulators.ni_daqmx_server.input_task import InputTask
from modallab_simulators.ni_daqmx_server.output_task import OutputTask
from modallab_simulators.ni_daqmx_server.plant import LATENCY_S
from modallab_simulators.ni_daqmx_server.signals import Pulses
from modallab_simulators.ni_daqmx_server.tasks import Task, terminal

if TYPE_CHECKING:
    from modallab_simulators.ni_daqmx_server.bench import SimulatedSystem

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
    return task.routed("DIG_EDGE_START_TRIG_SRC") if task.get("START_TRIG_TYPE") == DIGITAL_EDGE else ""


def _external_clock(task: Task) -> str:
    source = task.routed("SAMP_CLK_SRC")
    return "" if not source or source.endswith(_OWN) or task.timing != "clocked" else source


def _edge(system: "SimulatedSystem", source: str, at_s: float, begun: Task | None, *, rising: bool) -> float | None:
    if begun is not None and route(source) in start_terminals(begun):
        return begun_at(begun, system.clock.now())
    pulses = system.pulses(source)
    return None if pulses is None else pulses.edge_after(at_s, rising=rising)


def begun_at(task: Task, now_s: float) -> float:
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
    devices = {c.module.name for c in task.all_channels()} | {task.own_device}
    own = {f"/{device}/{kind_of(task)}/StartTrigger" for device in devices}
    exported = task.routed("START_TRIG_OUTPUT_TERM")
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
        f"/{device}/{kind}/SampleClock" for device in {c.module.name for c in task.all_channels()} | {task.own_device}
    }
    exported = task.routed("SAMP_CLK_OUTPUT_TERM")
    clocks = ends | ({route(exported)} if exported else set())
    return clock_pulses(task) if kind and route(source) in clocks else None


def _follow_reference(system: "SimulatedSystem", task: Task) -> None:
    """When the digital edge comes that a reference trigger waits for."""
    if not isinstance(task, InputTask) or task.trigger is None or task.trigger.channel >= 0 or task.waiting:
        return
    pulses = system.pulses(task.routed("DIG_EDGE_REF_TRIG_SRC"))
    full_s = task.start_s + task.trigger.pre_trigger / task.true_hz
    rising = task.get("DIG_EDGE_REF_TRIG_EDGE") != FALLING
    task.trigger_s = None if pulses is None else pulses.edge_after(full_s, rising=rising)
