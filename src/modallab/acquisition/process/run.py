"""One run, from its check to its end: however it ends, the output is at 0 V and what was acknowledged is kept."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from math import ceil
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.burst_watch import load_filters
from modallab.acquisition.monitor.context import Context
from modallab.acquisition.monitor.live import LiveRing, LiveTap
from modallab.acquisition.monitor.requests import DropBlock, Excitation, Requests
from modallab.acquisition.monitor.run_states import Emit, Lifecycle
from modallab.acquisition.monitor.stream import Stream
from modallab.acquisition.procedures.broadband import run_broadband
from modallab.acquisition.procedures.broadband_checks import longest_wave_s, require_waves
from modallab.acquisition.procedures.burst import longest_burst_s, tail_s
from modallab.acquisition.procedures.certificates import remarks_on
from modallab.acquisition.procedures.impact import run_impact
from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.acquisition.procedures.sensor_supply import PATIENCE_S, fed_channels, wait_until_settled
from modallab.acquisition.procedures.sine import run_sine
from modallab.acquisition.procedures.struck_point.expected import ExpectedModes
from modallab.acquisition.procedures.trigger import require_trigger
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.protocol import Bench, Delivery, Request
from modallab.bench.recut import Recut
from modallab.core.errors import BenchError, ModallabError, OutputLostError, PlanError, RigError
from modallab.core.events import BlockDropped, Failed, Notice
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan, records_of
from modallab.core.rig import Rig
from modallab.signals.conversion import Conversion
from modallab.storage import Recorder, Store
from modallab.storage.store import INTERRUPTED

Order = Literal["stop", "abort", "emergency", "ended", "lost"]
"""How a running test may be asked to end; `ended`: by the end of the service, `lost`: whoever asked for it is gone."""

Control = Callable[[], Order | None]

REAL_TIME_CHUNK_S = 0.05
FREE_CHUNK_S = 0.5
"""Read at once where time is virtual. A limit is looked at once a chunk."""

MEMORY_BLOCKS = 6
"""Blocks the stream remembers: the window before a hit, the hit, and some."""


class OrderedEndError(Exception):
    """The run was asked to end; not an error of the run."""

    def __init__(self, order: Order) -> None:
        super().__init__(order)
        self.order: Order = order


def run_plan(
    bench: Bench,
    rig: Rig,
    plan: Plan,
    recorder: Recorder,
    emit: Emit,
    control: Control = lambda: None,
    chunk_s: float | None = None,
    *,
    requests: Requests | None = None,
    latch: TripLatch | None = None,
    supervision: str = "",
    excitation: Excitation | None = None,
    live: LiveRing | None = None,
    expected: ExpectedModes | None = None,
) -> None:
    """Run a plan on an open bench, in this process.

    Args:
        bench: open, not started.
        rig: what stands on it.
        plan: what to do.
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
    life = Lifecycle(recorder, emit)
    chunk_s = chunk_s or (REAL_TIME_CHUNK_S if bench.info.real_time else FREE_CHUNK_S)
    setup = Setup(
        bench, rig, plan, recorder, emit, life, control, chunk_s,
        requests or Requests(), latch, supervision, excitation or Excitation(), live, expected,
    )  # fmt: skip
    try:
        try:
            _work_unless_ended(setup)
        except OrderedEndError as end:
            _make_safe(setup)
            _drop_left(setup)
            _end(setup, end.order)
    except BaseException as error:
        _make_safe(setup)
        _fail(life, recorder, emit, error)
        raise


def record(bench: Bench, rig: Rig, plan: Plan, store: Store, emit: Emit, control: Control = lambda: None) -> str:
    """Begin a run in a store, run the plan, let go of the run; returns its name. Raises as `run_plan`."""
    with store.begin(plan, rig, bench.info) as recorder:
        run_plan(bench, rig, plan, recorder, emit, control)
        return recorder.run


def make_safe(bench: Bench) -> list[BenchError]:
    """Bring the output to zero, then stop; what fails on the way keeps neither from being tried, and is returned."""
    failed: list[BenchError] = []
    for step in (bench.zero, bench.stop):
        try:
            step()
        except BenchError as error:
            failed.append(error)
    return failed


def _make_safe(setup: "Setup") -> None:
    # Where the output could not be brought to 0 V, the operator must know what to do, whatever ended the run.
    for error in make_safe(setup.bench)[:1]:
        remedy = f": {error.remedy}" if error.remedy else ""
        setup.emit(Notice(run=setup.recorder.run, what=f"0 V could not be reached: {error.what}{remedy}"))


def _work_unless_ended(setup: "Setup") -> None:
    try:
        _work(setup)
    except OutputLostError:
        # To the driver an emergency stop by another handle looks like a hand at the device.
        setup.poll()
        raise


@dataclass(frozen=True, slots=True)
class Setup:
    """What `run_plan` was given, and the state it keeps."""

    bench: Bench
    rig: Rig
    plan: Plan
    recorder: Recorder
    emit: Emit
    life: Lifecycle
    control: Control
    chunk_s: float
    requests: Requests = field(default_factory=Requests)
    latch: TripLatch | None = None
    supervision: str = ""
    excitation: Excitation = field(default_factory=Excitation)
    live: LiveRing | None = None
    expected: ExpectedModes | None = None

    def tap(self, delivery: Delivery) -> LiveTap | None:
        """Shows what comes, where it is to be shown."""
        return None if self.live is None else self.live.open(self.recorder.run, self.rig, delivery)

    def poll(self) -> None:
        """Look, before every read, whether the run shall go on.

        Raises:
            OrderedEndError: it was asked to end.
            TrippedError: somebody else has brought the output to 0 V.
        """
        order = self.control()
        if order is not None:
            raise OrderedEndError(order)
        trip = self.latch.read() if self.latch is not None and self.latch.tripped else None
        if trip is not None and trip.cause == "emergency stop":
            raise OrderedEndError("emergency")
        if trip is not None and self.latch is not None:
            self.latch.require_reset()


def _work(setup: Setup) -> None:
    setup.life.enter("arming")
    if setup.latch is not None:
        setup.latch.require_reset()
    require_possible(setup.plan, setup.rig, setup.bench.info)
    require_trigger(setup.plan, setup.bench)
    if isinstance(setup.plan, BroadbandPlan):
        require_waves(setup.plan, setup.bench, setup.rig)
    if isinstance(setup.plan, SinePlan | BroadbandPlan):
        setup.emit(Notice(run=setup.recorder.run, what=_what_ends_it(setup.plan, setup)))
    _require_sensors_known(setup)
    context = _prepare(setup)
    _wait_for_supplies(setup, context)
    if isinstance(setup.plan, ImpactPlan):
        run_impact(context, setup.plan, setup.expected)
    elif isinstance(setup.plan, BroadbandPlan):
        run_broadband(context, setup.plan)
    else:
        run_sine(context, setup.plan)
    setup.bench.zero()
    setup.bench.stop()
    _drop_left(setup)
    setup.life.enter("processing")
    setup.recorder.close_file()
    setup.life.enter("done")


def _what_ends_it(plan: SinePlan | BroadbandPlan, setup: Setup) -> str:
    longest = longest_burst_s(plan) if isinstance(plan, SinePlan) else longest_wave_s(plan, setup.rig)
    notice = f"longest burst {longest:.4g} s: "
    excitation = setup.rig.excitation
    if not setup.bench.info.streams_bursts:
        notice += "if any process fails, the output returns to 0 V by itself within that time"
    elif excitation is not None and excitation.watchdog_s is not None:
        notice += (
            f"if any process fails, the device's watchdog brings the output to 0 V after {excitation.watchdog_s:g} s"
        )
    else:
        waived = excitation.watchdog_waived if excitation is not None else ""
        notice += (
            "should this machine crash or sleep, or lose the device, in a burst, the output HOLDS ITS LAST VALUE: the"
            f" device has no watchdog; the rig file says: {waived}"
        )
    return f"{notice}; {setup.supervision}" if setup.supervision else notice


def _drop_left(setup: Setup) -> None:
    # A request that came after the last look is still a request; there is no more time to ask for the hit again.
    for request in setup.requests.take():
        if isinstance(request, DropBlock) and setup.recorder.drop(request.block, request.reason):
            setup.emit(BlockDropped(run=setup.recorder.run, name=request.block, reason=request.reason))


def _prepare(setup: Setup) -> Context:
    bench, plan = setup.bench, setup.plan
    bench.zero()
    delivery = bench.configure(Request(records_of(plan), plan.rate_hz))
    conversion = Conversion.of(setup.rig, records_of(plan), delivery.units, delivery.scale, delivery.dtype)
    block = round(plan.block_s * delivery.rate_hz)
    recut = _recut(plan, delivery)
    if recut is None:
        setup.recorder.open(delivery, block)
    else:
        setup.recorder.open(replace(delivery, rate_hz=recut.to_hz), recut.native)
    # At most half a block at once, so that a chunk never runs past the end of a block it triggered.
    chunk = max(1, min(round(setup.chunk_s * delivery.rate_hz), block // 2))
    # A block is looked at, and written, when its burst has ended.
    tail = ceil(tail_s(plan) * delivery.rate_hz) if isinstance(plan, SinePlan) else 0
    keep = MEMORY_BLOCKS * block + tail
    stream = Stream(bench, delivery, conversion, keep=keep, chunk=chunk, poll=setup.poll, tap=setup.tap(delivery))
    load_filters(setup.rig.limits)
    bench.start()
    return Context(
        bench, setup.rig, setup.recorder, setup.emit, setup.life, conversion, stream, block, recut,
        setup.requests, setup.excitation,
    )  # fmt: skip


def _require_sensors_known(setup: Setup) -> None:
    remarks = remarks_on(setup.rig, records_of(setup.plan), datetime.now(UTC).date(), setup.bench)
    for remark in remarks:
        setup.emit(Notice(run=setup.recorder.run, what=f"{remark.channel}: {remark.what}"))
    wrong = [f"{remark.channel}: {remark.what}" for remark in remarks if remark.contradiction]
    if wrong:
        raise RigError("; ".join(wrong), where="sensors", remedy="check which sensor is mounted; correct the rig file")


def _wait_for_supplies(setup: Setup, context: Context) -> None:
    fed, stream = fed_channels(setup.bench, setup.rig), context.stream
    if not fed:
        return
    run = setup.recorder.run
    what = f"{len(fed)} sensors are fed; waiting until their bias has settled, at most {PATIENCE_S:g} s"
    setup.emit(Notice(run=run, what=what))

    def pull(count: int) -> NDArray[np.generic]:
        pieces: list[NDArray[np.generic]] = []
        stream.advance_to(stream.next + count, lambda chunk: pieces.append(chunk.samples))
        return np.concatenate(pieces, axis=1)

    wait = wait_until_settled(pull, fed, stream.rate_hz)
    if wait.unsettled:
        what = f"the bias of {', '.join(wait.unsettled)} still moves after {wait.seconds:g} s; look at sensor and cable"
        setup.emit(Notice(run=run, what=what))


def _recut(plan: Plan, delivery: Delivery) -> Recut | None:
    if plan.delivered_hz is None or plan.delivered_hz == delivery.rate_hz:
        return None
    if plan.delivered_hz > delivery.rate_hz:
        raise PlanError(
            f"delivered_hz: {plan.delivered_hz:g} Hz; allowed: up to the device's rate, {delivery.rate_hz:g} Hz",
            where=f"{plan.kind} plan",
            remedy="ask for a lower delivered rate, or a higher rate_hz",
        )
    return Recut.of(delivery.rate_hz, plan.delivered_hz, plan.block_s)


def _end(setup: Setup, order: Order) -> None:
    life = setup.life
    life.enter("stopping", _SAID[order])
    if order == "stop":
        life.enter("done", _SAID[order])
    elif order in ("abort", "emergency"):
        life.enter("aborted", _SAID[order], valid=False)
    else:
        life.enter("failed", _SAID[order])
        setup.emit(
            Failed(run=setup.recorder.run, code=INTERRUPTED, what=_SAID[order], remedy="continue it as a new run")
        )


_SAID: dict[Order, str] = {
    "stop": "stopped by the operator",
    "abort": "aborted by the operator",
    "emergency": "emergency stop",
    "ended": "interrupted: the service was ended",
    "lost": "interrupted: the process that asked for the run is gone",
}


def _fail(life: Lifecycle, recorder: Recorder, emit: Emit, error: BaseException) -> None:
    known = error if isinstance(error, ModallabError) else ModallabError(f"unexpected {type(error).__name__}: {error}")
    try:
        if life.state != "stopping":
            life.enter("stopping", known.what)
        life.enter("failed", known.what)
    except ModallabError:
        # A full disk may take not even the state; the next start marks the run as interrupted.
        pass
    emit(Failed(run=recorder.run, code=known.code, what=known.what, remedy=known.remedy))
