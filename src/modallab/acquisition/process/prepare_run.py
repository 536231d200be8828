"""What a run is given and how it is made ready: the state it keeps, and what must hold before anything moves."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from math import ceil, isclose
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.burst_watch import import_motion_limits
from modallab.acquisition.monitor.context import RunContext
from modallab.acquisition.monitor.live import LiveRingBuffer, LiveTap
from modallab.acquisition.monitor.run_states import Emit, ExcitationState, OperatorRequests, RunLifecycle
from modallab.acquisition.monitor.stream import BenchStream
from modallab.acquisition.procedures.broadband_checks import longest_wave_s
from modallab.acquisition.procedures.burst import longest_burst_s, time_to_end_of_burst_s
from modallab.acquisition.procedures.sensors import PATIENCE_S, sensor_remarks, supplied_channels, wait_until_settled
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes
from modallab.acquisition.process.trip import TripLatch
from modallab.bench.protocol import AcquisitionRequest, Bench, DeliveredSampling
from modallab.bench.resampling import ResamplingRule
from modallab.core.errors import PlanError, RigError
from modallab.core.events import OperatorNotice
from modallab.core.plan import BroadbandPlan, Plan, SinePlan, test_of_plan
from modallab.core.rig import Rig
from modallab.signals.conversion import Conversion
from modallab.storage import Recorder

Order = Literal["stop", "abort", "emergency", "ended", "lost"]
"""How a running test may be asked to end; `ended`: by the end of the service, `lost`: whoever asked for it is gone."""

Control = Callable[[], Order | None]

MEMORY_BLOCKS = 6
"""Blocks the stream remembers: the window before a hit, the hit, and some."""


class OrderedStopError(Exception):
    """The run was asked to end; not an error of the run."""

    def __init__(self, order: Order) -> None:
        super().__init__(order)
        self.order: Order = order


@dataclass(frozen=True, slots=True)
class RunSetup:
    """What `run_plan` was given, and the state it keeps."""

    bench: Bench
    rig: Rig
    plan: Plan
    recorder: Recorder
    emit: Emit
    life: RunLifecycle
    control: Control
    chunk_s: float
    requests: OperatorRequests = field(default_factory=OperatorRequests)
    latch: TripLatch | None = None
    supervision: str = ""
    excitation: ExcitationState = field(default_factory=ExcitationState)
    live: LiveRingBuffer | None = None
    expected: ExpectedModes | None = None

    def show_samples(self, delivery: DeliveredSampling) -> LiveTap | None:
        """Shows what comes, where it is to be shown."""
        return None if self.live is None else self.live.open(self.recorder.run, self.rig, delivery)

    def poll(self) -> None:
        """Look, before every read, whether the run shall go on.

        Raises:
            OrderedStopError: it was asked to end.
            TrippedError: somebody else has brought the output to 0 V.
        """
        order = self.control()
        if order is not None:
            raise OrderedStopError(order)
        trip = self.latch.read() if self.latch is not None and self.latch.is_tripped else None
        if trip is not None and trip.cause == "emergency stop":
            raise OrderedStopError("emergency")
        if trip is not None and self.latch is not None:
            self.latch.require_reset()


def output_stop_in_words(plan: SinePlan | BroadbandPlan, setup: RunSetup) -> str:
    """What brings the output to 0 V should a process or this machine fail, in words."""
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


def prepare_run(setup: RunSetup) -> RunContext:
    """Configure the bench, open the record, and start streaming."""
    bench, plan = setup.bench, setup.plan
    bench.zero()
    delivery = bench.configure(AcquisitionRequest(test_of_plan(plan), plan.rate_hz))
    _report_rate(setup, delivery)
    conversion = Conversion.of(setup.rig, test_of_plan(plan), delivery.units, delivery.scale, delivery.dtype)
    block = round(plan.block_s * delivery.rate_hz)
    recut = _recut_of_plan(plan, delivery)
    if recut is None:
        setup.recorder.open(delivery, block)
    else:
        setup.recorder.open(replace(delivery, rate_hz=recut.to_hz), recut.native)
    # At most half a block at once, so that a chunk never runs past the end of a block it triggered.
    chunk = max(1, min(round(setup.chunk_s * delivery.rate_hz), block // 2))
    # A block is looked at, and written, when its burst has ended.
    tail = ceil(time_to_end_of_burst_s(plan) * delivery.rate_hz) if isinstance(plan, SinePlan) else 0
    keep = MEMORY_BLOCKS * block + tail
    stream = BenchStream(
        bench, delivery, conversion, keep=keep, chunk=chunk, poll=setup.poll, tap=setup.show_samples(delivery)
    )
    import_motion_limits(setup.rig.limits)
    bench.start()
    return RunContext(
        bench, setup.rig, setup.recorder, setup.emit, setup.life, conversion, stream, block, recut,
        setup.requests, setup.excitation,
    )  # fmt: skip


def _report_rate(setup: RunSetup, delivery: DeliveredSampling) -> None:
    asked_hz, given_hz = delivery.requested_rate_hz, delivery.rate_hz
    if not isclose(asked_hz, given_hz, rel_tol=1e-9):
        what = f"the device samples at {given_hz:.10g} Hz; {asked_hz:.10g} Hz was requested"
        setup.emit(OperatorNotice(run=setup.recorder.run, what=what))


def require_sensors_known(setup: RunSetup) -> None:
    """Report what certificates and sensors say of each other.

    Raises:
        RigError: they contradict the rig file.
    """
    remarks = sensor_remarks(setup.rig, test_of_plan(setup.plan), datetime.now(UTC).date(), setup.bench)
    for remark in remarks:
        setup.emit(OperatorNotice(run=setup.recorder.run, what=f"{remark.channel}: {remark.what}"))
    wrong = [f"{remark.channel}: {remark.what}" for remark in remarks if remark.contradiction]
    if wrong:
        raise RigError("; ".join(wrong), where="sensors", remedy="check which sensor is mounted; correct the rig file")


def wait_for_supplies(setup: RunSetup, context: RunContext) -> None:
    """Wait until the bias of fed sensors has settled, and report those whose bias has not."""
    fed, stream = supplied_channels(setup.bench, setup.rig), context.stream
    if not fed:
        return
    run = setup.recorder.run
    what = f"{len(fed)} sensors have their supply on; waiting until their bias has settled, at most {PATIENCE_S:g} s"
    setup.emit(OperatorNotice(run=run, what=what))

    def pull(count: int) -> NDArray[np.generic]:
        pieces: list[NDArray[np.generic]] = []
        stream.advance_to(stream.next + count, lambda chunk: pieces.append(chunk.samples))
        return np.concatenate(pieces, axis=1)

    wait = wait_until_settled(pull, fed, stream.rate_hz)
    if wait.unsettled:
        what = f"the bias of {', '.join(wait.unsettled)} still moves after {wait.seconds:g} s; check sensor and cable"
        setup.emit(OperatorNotice(run=run, what=what))


def _recut_of_plan(plan: Plan, delivery: DeliveredSampling) -> ResamplingRule | None:
    if plan.delivered_hz is None or plan.delivered_hz == delivery.rate_hz:
        return None
    if plan.delivered_hz > delivery.rate_hz:
        raise PlanError(
            f"delivered_hz: {plan.delivered_hz:g} Hz; allowed: up to the device's rate, {delivery.rate_hz:g} Hz",
            where=f"{plan.kind} plan",
            remedy="ask for a lower delivered rate, or a higher rate_hz",
        )
    return ResamplingRule.of(delivery.rate_hz, plan.delivered_hz, plan.block_s)
