"""The impact test: at every point, wait for rest, ask for a hit, keep it, say whether it counts."""

from dataclasses import asdict, dataclass, field

from modallab.acquisition.monitor.context import RunContext, measure_floor
from modallab.acquisition.monitor.run_states import AcceptBlock, DropBlock
from modallab.acquisition.monitor.settled import NoiseFloor
from modallab.acquisition.procedures.hit_acceptance import (
    HitQueue,
    MeasuredHit,
    MotionBeforeHit,
    hit_of,
    rejection_reasons,
)
from modallab.acquisition.procedures.rest import EarlyHits, HitMotion, RestState, RestWait
from modallab.acquisition.procedures.struck_point.check import HitLocation, StruckPointCheck
from modallab.acquisition.procedures.struck_point.participation import ExpectedModes, response_of_hit
from modallab.acquisition.procedures.target import HitTarget
from modallab.acquisition.procedures.trigger import Trigger, wait_for_record
from modallab.core.errors import BenchError, BenchTimeoutError, SamplesLostError
from modallab.core.events import BlockAcknowledged, DecisionRequested, HitRejected, HitRequested, WaitingForRest
from modallab.core.plan import ImpactPlan
from modallab.storage import BlockNote


@dataclass(slots=True)
class ImpactTest:
    """One impact test on a started bench.

    Attributes:
        context: the bench.
        plan: points, hits, trigger, acceptance.
        rest: waits for rest.
        struck: knows which point a hit has struck.
        queue: hits that are requested, and those that count.
        rejected: rejected hits at the present point.
        restarts: how often the bench had to be started again.
        changed: whether the operator has changed what comes next.
        undecided: name of the block that the operator is asked about; "" if of none.
    """

    context: RunContext
    plan: ImpactPlan
    rest: RestWait
    struck: StruckPointCheck
    queue: HitQueue
    rejected: int = 0
    restarts: int = 0
    changed: bool = field(default=False)
    undecided: str = ""

    def run(self) -> None:
        """All points, all hits; a hit that is dropped is asked for again.

        Raises:
            BenchTimeoutError: no hit came in time.
            BenchError: too many hits at one point were rejected.
            SamplesLostError: the device lost samples too often.
        """
        point = 0
        while self.queue.todo:
            target = self.queue.current_hit
            if target.point != point:
                point, self.rejected = target.point, 0
            self.changed = False
            try:
                self.context.pause_if_requested()
                self._hit(target)
            except SamplesLostError as error:
                self.restarts += 1
                self.context.restart(error, self.restarts)
                self.rest.early.stream_restarted()
                self._notify_rejected(target.point, f"samples were lost: {error.what}; the bench was restarted")

    def _hit(self, target: HitTarget) -> None:
        rest = self.rest.wait(target.point, self._interrupted, self._report_rest)
        trigger = None if self._interrupted() else self._wait_for_hit(target)
        if trigger is None:
            return
        first = trigger - self._pre_trigger
        # While the block still comes: at its end the operator waits for the verdict.
        before = MotionBeforeHit.of(self.context, first, self.rest.floor)
        self.context.stream.advance_to(first + self.context.block)
        self._keep(target, first, rest, before)
        if self.plan.trigger == "hardware":
            self.context.stream.restart()
            self.rest.early.stream_restarted()

    @property
    def _pre_trigger(self) -> int:
        return self.context.stream.samples_of(self.plan.pre_trigger_s)

    def _interrupted(self) -> bool:
        """Whether the present hit must not be waited for any more, after a look at what the operator wants."""
        self._obey()
        return self.changed or self.context.pause_requested

    def _obey(self) -> None:
        for request in self.context.requests.take_all():
            if isinstance(request, DropBlock | AcceptBlock) and request.block == self.undecided:
                self.undecided = ""
            if isinstance(request, DropBlock) and self.queue.drop_hit(self.context, request):
                self.struck.remove_hit(request.block)
                self.rest.motion.remove_hit(request.block)
                self.changed = True
            elif isinstance(request, AcceptBlock):
                target = self.queue.accept_hit(self.context, request)
                if target is not None:
                    self.struck.keep_hit(request.block, request.block, target.point)
                    self.changed = True
                    self._progress(f"point {target.point}, hit {target.hit} of {self.plan.hits}")

    def _progress(self, what: str) -> None:
        self.context.report_progress(len(self.queue.kept), self.queue.total, what)

    def _report_rest(self, rest: RestState, remaining_s: float | None) -> None:
        target, limit = self.queue.current_hit, self.plan.acceptance.max_residual_ratio
        self.context.emit(
            WaitingForRest(
                run=self.context.recorder.run, point=target.point, hit=target.hit, of=self.plan.hits,
                residual_ratio=rest.ratio, allowed=limit, residual_hz=rest.hz, remaining_s=remaining_s,
            )
        )  # fmt: skip

    def _ask(self, target: HitTarget) -> None:
        context = self.context
        if context.life.state == "arming":
            context.life.enter_state("armed")
        context.emit(HitRequested(run=context.recorder.run, point=target.point, hit=target.hit, of=self.plan.hits))
        context.bench.prompt_hit(target.point)

    def _wait_for_hit(self, target: HitTarget) -> int | None:
        """The sample of the trigger; None if a pause or another request came first."""
        context, plan, stream = self.context, self.plan, self.context.stream
        if plan.trigger == "hardware":
            found = wait_for_record(context, plan, lambda: self._ask(target), self._interrupted)
            if found is not None and context.life.state == "armed":
                context.life.enter_state("acquiring")
            return found
        trigger = Trigger(plan.trigger_n, plan.hysteresis_n)
        last = stream.next + stream.samples_of(plan.hit_timeout_s)
        self._ask(target)
        while stream.next < last:
            if self._interrupted():
                return None
            chunk = stream.read_samples(stream.chunk)
            found = trigger.scan(context.conversion.force_n(chunk.samples))
            if found is not None:
                if context.life.state == "armed":
                    context.life.enter_state("acquiring")
                return chunk.first_sample + found
        raise BenchTimeoutError(
            f"no hit above {plan.trigger_n:g} N at point {target.point} within {plan.hit_timeout_s:g} s",
            where=context.bench.info.url,
            remedy="strike harder, lower trigger_n, or check the hammer's cable; earlier blocks are kept",
        )

    def _keep(self, target: HitTarget, first: int, rest: RestState, before: MotionBeforeHit) -> None:
        context, limits = self.context, self.plan.acceptance
        placed = context.place_block(first)
        overload = context.stream.overloaded_channels(first, context.block)
        hit, ringing = self._measure(first), before.relative_to_block(context, first, self.rest.floor)
        overloaded = [f"overload: {', '.join(overload)} beyond the range"] if overload else []
        unclean = [*overloaded, *rejection_reasons(hit, limits)]
        # What is no clean hit says little about where it was.
        where = HitLocation() if unclean else self._where(target, first)
        reasons = [*unclean, *where.reasons, *ringing.rejection_reasons(limits.max_residual_ratio)]
        name = self.queue.next_name() if reasons else target.name
        note = BlockNote(
            name=name,
            test="impact",
            first_sample=first,
            drive_point=target.point,
            accepted=not reasons,
            reason="; ".join(reasons),
            overload=overload,
            facts={**asdict(hit), **asdict(ringing), **rest.facts(context.line_hz), **where.facts()},
        )
        kept = context.keep_block(first, placed, note)
        if not unclean and not where.reasons:
            # One that only came too soon after another says as well how much a hit moves the structure.
            self._learn_motion(name, target.point, first)
        if reasons:
            self._reject(target.point, name, note.reason)
            self._let_operator_decide(kept, target.point)
            return
        self.struck.keep_hit(self.queue.next_name(), name, target.point)
        self.queue.keep_hit()
        self._let_operator_decide(kept, target.point)
        self._obey()
        self._progress(f"point {target.point}, hit {target.hit} of {self.plan.hits}")

    def _let_operator_decide(self, block: BlockAcknowledged, point: int) -> None:
        """Where the plan wants it, wait until the operator has accepted or dropped the block."""
        asked = self.plan.operator_decides
        if asked == "never" or (asked == "rejected" and block.accepted):
            return
        self.undecided = block.name
        self.context.emit(
            DecisionRequested(
                run=block.run, n=block.n, name=block.name, point=point, accepted=block.accepted, reason=block.reason
            )
        )
        while self.undecided:
            self._obey()
            if self.undecided:
                self.context.watch_while_waiting()

    def _learn_motion(self, name: str, point: int, first: int) -> None:
        context = self.context
        force_n = context.conversion.force_n(context.stream.view_samples(first, context.block))
        motion = context.motion_samples(first, context.block)
        self.rest.motion.add_hit(name, point, force_n, motion, context.rest_window, self.rest.floor)

    def _measure(self, first: int) -> MeasuredHit:
        context = self.context
        force_n = context.conversion.force_n(context.stream.view_samples(first, context.block))
        return hit_of(force_n, context.stream.rate_hz, self._pre_trigger, self.plan.acceptance.min_band_hz)

    def _where(self, target: HitTarget, first: int) -> HitLocation:
        context = self.context
        if not self.plan.acceptance.check_point:
            return HitLocation()
        samples = context.stream.view_samples(first, context.block)
        answer = response_of_hit(
            samples,
            context.conversion,
            context.stream.rate_hz,
            self._pre_trigger,
            self.struck.checked_rows,
            self.struck.up_to_hz,
        )
        return HitLocation() if answer is None else self.struck.check_hit(self.queue.next_name(), target.point, answer)

    def _reject(self, point: int, name: str, reason: str) -> None:
        self.queue.reject_hit(name)
        self.rejected += 1
        self._notify_rejected(point, reason)
        if self.rejected > self.plan.max_rejections:
            raise BenchError(
                f"{self.rejected} hits at point {point} were rejected, the last one: {reason}",
                where=self.context.bench.info.url,
                remedy="change the hammer tip, the place or the acceptance limits; recorded blocks are kept",
            )

    def _notify_rejected(self, point: int, reason: str) -> None:
        self.context.emit(HitRejected(run=self.context.recorder.run, point=point, reason=reason))


def run_impact(context: RunContext, plan: ImpactPlan, expected: ExpectedModes | None = None) -> None:
    """Measure the floor, then run the test; see `ImpactTest`.

    Args:
        context: the bench.
        plan: plan of the run.
        expected: the modes the structure is believed to have, if any are.
    """
    early = EarlyHits(context, plan, plan.points[0])
    motion = HitMotion(tuple(context.rig.channels[i].point or 0 for i in context.conversion.motion))
    rest = RestWait(context, plan, _undisturbed_floor(context, plan, early), early, motion)
    struck = StruckPointCheck.of(context.rig, context.conversion, plan.acceptance.min_band_hz, expected)
    ImpactTest(context, plan, rest, struck, HitQueue.of(plan)).run()


def _undisturbed_floor(context: RunContext, plan: ImpactPlan, early: EarlyHits) -> NoiseFloor:
    """The floor, again if somebody struck meanwhile, as long as the plan's patience lasts."""
    last = context.stream.next + context.stream.samples_of(plan.hit_timeout_s)
    while True:
        seen = early.seen
        floor = measure_floor(context, plan.hit_timeout_s, early)
        if early.seen == seen or context.stream.next >= last:
            return floor
