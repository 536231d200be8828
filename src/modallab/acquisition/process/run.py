"""One run, from its check to its end: however it ends, the output is at 0 V and what was acknowledged is kept."""

from modallab.acquisition.monitor.live import LiveRingBuffer
from modallab.acquisition.monitor.run_states import DropBlock, Emit, ExcitationState, OperatorRequests, RunLifecycle
from modallab.acquisition.procedures.broadband import run_broadband
from modallab.acquisition.procedures.broadband_checks import require_waves
from modallab.acquisition.procedures.impact import run_impact
from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.procedures.sine import run_sine
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.acquisition.procedures.trigger import require_trigger
from modallab.acquisition.process.prepare_run import (
    Control,
    Order,
    OrderedStopError,
    RunSetup,
    output_stop_in_words,
    prepare_run,
    require_sensors_known,
    wait_for_supplies,
)
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.protocol import Bench
from modallab.core.errors import BenchError, ModallabError, OutputLostError
from modallab.core.events import BlockDropped, OperatorNotice, RunFailed
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.storage import Recorder, Store
from modallab.storage.store import INTERRUPTED

REAL_TIME_CHUNK_S = 0.05
FREE_CHUNK_S = 0.5
"""Read at once where time is virtual. A limit is looked at once a chunk."""


def run_plan(
    bench: Bench,
    rig: Rig,
    plan: Plan,
    recorder: Recorder,
    emit: Emit,
    control: Control = lambda: None,
    chunk_s: float | None = None,
    *,
    requests: OperatorRequests | None = None,
    latch: TripLatch | None = None,
    supervision: str = "",
    excitation: ExcitationState | None = None,
    live: LiveRingBuffer | None = None,
    expected: ExpectedModes | None = None,
) -> None:
    """Run a plan on an open bench, in this process.

    Args:
        bench: open, not started.
        rig: what stands on it.
        plan: plan of the run.
        recorder: of a run just begun.
        emit: takes the events, in order.
        control: asked before every read whether to end.
        chunk_s: how much to read at once; nothing that is recorded depends on it.
        requests: what else is requested of the test while it runs.
        latch: of the emergency stop; without one there is none.
        supervision: what ends the output should this process die; reported before anything is driven.
        excitation: set to whether a burst may be on.
        live: where samples are shown as they come.
        expected: the modes the structure is believed to have, to see which point a hit has struck.

    Raises:
        TrippedError: the rig was tripped and not reset.
        ModallabError: what ended the run early, after the output was brought to zero and `Failed` was reported.
    """
    life = RunLifecycle(recorder, emit)
    chunk_s = chunk_s or (REAL_TIME_CHUNK_S if bench.info.real_time else FREE_CHUNK_S)
    setup = RunSetup(
        bench, rig, plan, recorder, emit, life, control, chunk_s,
        requests or OperatorRequests(), latch, supervision, excitation or ExcitationState(), live, expected,
    )  # fmt: skip
    try:
        try:
            _work_unless_ended(setup)
        except OrderedStopError as end:
            _make_safe(setup)
            _drop_left(setup)
            _end(setup, end.order)
    except BaseException as error:
        _make_safe(setup)
        _fail(life, recorder, emit, error)
        raise


def record_run(bench: Bench, rig: Rig, plan: Plan, store: Store, emit: Emit, control: Control = lambda: None) -> str:
    """Begin a run in a store, run the plan, let go of the run; returns its name. Raises as `run_plan`."""
    with store.begin(plan, rig, bench.info) as recorder:
        run_plan(bench, rig, plan, recorder, emit, control)
        return recorder.run


def stop_output_and_bench(bench: Bench) -> list[BenchError]:
    """Bring the output to zero, then stop; what fails on the way keeps neither from being tried, and is returned."""
    failed: list[BenchError] = []
    for step in (bench.zero, bench.stop):
        try:
            step()
        except BenchError as error:
            failed.append(error)
    return failed


def _make_safe(setup: RunSetup) -> None:
    # Where the output could not be brought to 0 V, the operator must know what to do, whatever ended the run.
    for error in stop_output_and_bench(setup.bench)[:1]:
        remedy = f": {error.remedy}" if error.remedy else ""
        setup.emit(OperatorNotice(run=setup.recorder.run, what=f"0 V could not be reached: {error.what}{remedy}"))


def _work_unless_ended(setup: RunSetup) -> None:
    try:
        _work(setup)
    except OutputLostError:
        # To the driver an emergency stop by another handle looks like a hand at the device.
        setup.poll()
        raise


def _work(setup: RunSetup) -> None:
    setup.life.enter_state("arming")
    if setup.latch is not None:
        setup.latch.require_reset()
    require_possible(setup.plan, setup.rig, setup.bench.info)
    require_trigger(setup.plan, setup.bench)
    if isinstance(setup.plan, BroadbandPlan):
        require_waves(setup.plan, setup.bench, setup.rig)
    if isinstance(setup.plan, SinePlan | BroadbandPlan):
        setup.emit(OperatorNotice(run=setup.recorder.run, what=output_stop_in_words(setup.plan, setup)))
    require_sensors_known(setup)
    context = prepare_run(setup)
    wait_for_supplies(setup, context)
    if isinstance(setup.plan, ImpactPlan):
        run_impact(context, setup.plan, setup.expected)
    elif isinstance(setup.plan, BroadbandPlan):
        run_broadband(context, setup.plan)
    else:
        run_sine(context, setup.plan)
    setup.bench.zero()
    setup.bench.stop()
    _drop_left(setup)
    setup.life.enter_state("processing")
    setup.recorder.close_file()
    setup.life.enter_state("done")


def _drop_left(setup: RunSetup) -> None:
    # A request that came after the last look is still a request; there is no more time to ask for the hit again.
    for request in setup.requests.take_all():
        if isinstance(request, DropBlock) and setup.recorder.drop_block(request.block, request.reason):
            setup.emit(BlockDropped(run=setup.recorder.run, name=request.block, reason=request.reason))


def _end(setup: RunSetup, order: Order) -> None:
    life = setup.life
    life.enter_state("stopping", _SAID[order])
    if order == "stop":
        life.enter_state("done", _SAID[order])
    elif order in ("abort", "emergency"):
        life.enter_state("aborted", _SAID[order], valid=False)
    else:
        life.enter_state("failed", _SAID[order])
        setup.emit(
            RunFailed(
                run=setup.recorder.run, code=INTERRUPTED, what=_SAID[order], remedy="continue the run as a new run"
            )
        )


_SAID: dict[Order, str] = {
    "stop": "stopped by the operator",
    "abort": "aborted by the operator",
    "emergency": "emergency stop",
    "ended": "interrupted: the service was ended",
    "lost": "interrupted: the process that requested the run has ended",
}


def _fail(life: RunLifecycle, recorder: Recorder, emit: Emit, error: BaseException) -> None:
    known = error if isinstance(error, ModallabError) else ModallabError(f"unexpected {type(error).__name__}: {error}")
    try:
        if life.state != "stopping":
            life.enter_state("stopping", known.what)
        life.enter_state("failed", known.what)
    except ModallabError:
        # A full disk may take not even the state; the next start marks the run as interrupted.
        pass
    emit(RunFailed(run=recorder.run, code=known.code, what=known.what, remedy=known.remedy))
