"""The impact test: at every point, wait for rest, ask for a hit, keep it, say whether it counts."""

from collections import deque
from dataclasses import asdict, dataclass, field, replace

from modallab.acquisition.monitor.context import Context, measure_floor
from modallab.acquisition.monitor.requests import DropBlock
from modallab.acquisition.monitor.settled import Floor, SettledCheck
from modallab.acquisition.procedures.hit_acceptance import Hit, Ringing, hit_of, rejections, ringing_before
from modallab.acquisition.procedures.target import Target
from modallab.acquisition.procedures.trigger import Trigger, wait_for_record
from modallab.core.errors import BenchError, BenchTimeoutError, SamplesLostError
from modallab.core.events import HitRejected, HitRequested
from modallab.core.plan import ImpactPlan
from modallab.storage import BlockNote

NOTIFY_BLOCKS = 5
"""While the beam rings down, say so once in so many blocks."""


@dataclass(slots=True)
class ImpactTest:
    """One impact test on a started bench.

    Attributes:
        context: the bench.
        plan: points, hits, trigger, acceptance.
        floor: noise at rest.
        rejected: rejected hits at the present point.
        restarts: how often the bench had to be started anew.
        todo: hits that are still requested.
        kept: good hits by the name of their record.
    """

    context: Context
    plan: ImpactPlan
    floor: Floor
    rejected: int = 0
    restarts: int = 0
    todo: deque[Target] = field(default_factory=deque[Target])
    kept: dict[str, Target] = field(default_factory=dict[str, Target])

    def run(self) -> None:
        """All points, all hits; a hit that is dropped is asked for again.

        Raises:
            BenchTimeoutError: no hit came in time.
            BenchError: too many hits at one point were rejected.
            SamplesLostError: the device lost samples too often.
        """
        self.todo.extend(Target(point, hit) for point in self.plan.points for hit in range(1, self.plan.hits + 1))
        point = 0
        while self.todo:
            target = self.todo.popleft()
            if target.point != point:
                point, self.rejected = target.point, 0
            self._good_hit(target)
            self.kept[target.name] = target
            self._obey()
            self.context.progress(*self._progress, f"point {target.point}, hit {target.hit} of {self.plan.hits}")

    @property
    def _progress(self) -> tuple[int, int]:
        """Good hits, and how many are requested."""
        return len(self.kept), len(self.plan.points) * self.plan.hits

    def _obey(self) -> None:
        for request in self.context.requests.take():
            if isinstance(request, DropBlock) and self.context.drop(request.block, request.reason):
                target = self.kept.pop(request.block, None)
                if target is not None:
                    self.todo.appendleft(replace(target, again=target.again + 1))

    def _good_hit(self, target: Target) -> None:
        rejected_before = self.rejected
        good = False
        while not good:
            try:
                self.context.pause_if_requested()
                good = self._hit(target, self.rejected - rejected_before)
            except SamplesLostError as error:
                self.restarts += 1
                self.context.restart(error, self.restarts)
                self._notify_rejected(target.point, f"samples were lost: {error.what}; the bench was started anew")

    def _hit(self, target: Target, rejected: int) -> bool:
        rest = self._wait_until_settled()
        trigger = None if self.context.pause_requested else self._wait_for_hit(target)
        if trigger is None:
            return False
        first = trigger - self._pre_trigger
        self.context.stream.advance_to(first + self.context.block)
        good = self._keep(target.point, (target.name, f"_rejected_{rejected + 1}"), first, rest)
        if self.plan.trigger == "hardware":
            self.context.stream.restart()
        return good

    @property
    def _pre_trigger(self) -> int:
        return self.context.stream.samples_of(self.plan.pre_trigger_s)

    def _wait_until_settled(self) -> SettledCheck:
        """Read until the beam rests, block by block; past the plan's patience go on with what there is."""
        context, stream = self.context, self.context.stream
        last = stream.next + stream.samples_of(self.plan.hit_timeout_s)
        waited = 0
        while not (rest := context.check_settled_now(self.floor)).settled and stream.next < last:
            self._obey()
            if context.pause_requested:
                break
            waited += 1
            if waited % NOTIFY_BLOCKS == 0:
                context.progress(*self._progress, f"waiting for rest: {rest.line * context.line_hz:.4g} Hz still rings")
            stream.advance_to(stream.next + context.block)
        return rest

    def _ask(self, target: Target) -> None:
        context = self.context
        if context.life.state == "arming":
            context.life.enter("armed")
        context.emit(HitRequested(run=context.recorder.run, point=target.point, hit=target.hit, of=self.plan.hits))
        context.bench.prompt_hit(target.point)

    def _wait_for_hit(self, target: Target) -> int | None:
        """The sample of the trigger; None if a pause came first."""
        context, plan, stream = self.context, self.plan, self.context.stream
        if plan.trigger == "hardware":
            found = wait_for_record(context, plan, lambda: self._ask(target), self._obey)
            if found is not None and context.life.state == "armed":
                context.life.enter("acquiring")
            return found
        trigger = Trigger(plan.trigger_n, plan.hysteresis_n)
        last = stream.next + stream.samples_of(plan.hit_timeout_s)
        self._ask(target)
        while stream.next < last:
            self._obey()
            if context.pause_requested:
                return None
            chunk = stream.pull(stream.chunk)
            found = trigger.scan(context.conversion.force_n(chunk.samples))
            if found is not None:
                if context.life.state == "armed":
                    context.life.enter("acquiring")
                return chunk.first_sample + found
        raise BenchTimeoutError(
            f"no hit above {plan.trigger_n:g} N at point {target.point} within {plan.hit_timeout_s:g} s",
            where=context.bench.info.url,
            remedy="strike harder, lower trigger_n, or look at the hammer's cable; the blocks before are kept",
        )

    def _keep(self, point: int, name: tuple[str, str], first: int, rest: SettledCheck) -> bool:
        context = self.context
        overload = context.stream.overload(first, context.block)
        hit, ringing = self._measure(first)
        reasons = [
            *([f"overload: {', '.join(overload)} beyond the range"] if overload else []),
            *rejections(hit, self.plan.acceptance),
            *ringing.rejections(self.plan.acceptance.max_residual_ratio),
        ]
        note = BlockNote(
            name="".join(name) if reasons else name[0],
            test="impact",
            first_sample=first,
            drive_point=point,
            accepted=not reasons,
            reason="; ".join(reasons),
            overload=overload,
            facts={**asdict(hit), **asdict(ringing), **rest.facts(context.line_hz)},
        )
        context.record(first, note)
        if reasons:
            self._reject(point, note.reason)
        return not reasons

    def _measure(self, first: int) -> tuple[Hit, Ringing]:
        context = self.context
        force_n = context.conversion.force_n(context.stream.cut(first, context.block))
        hit = hit_of(force_n, context.stream.rate_hz, self._pre_trigger, self.plan.acceptance.min_band_hz)
        return hit, ringing_before(context, first, self.floor)

    def _reject(self, point: int, reason: str) -> None:
        self.rejected += 1
        self._notify_rejected(point, reason)
        if self.rejected > self.plan.max_rejections:
            raise BenchError(
                f"{self.rejected} hits at point {point} were rejected, the last one: {reason}",
                where=self.context.bench.info.url,
                remedy="change the tip, the place or the acceptance; the blocks are kept",
            )

    def _notify_rejected(self, point: int, reason: str) -> None:
        self.context.emit(HitRejected(run=self.context.recorder.run, point=point, reason=reason))


def run_impact(context: Context, plan: ImpactPlan) -> None:
    """Measure the floor, then run the test; see `ImpactTest`."""
    ImpactTest(context, plan, measure_floor(context, plan.hit_timeout_s)).run()
