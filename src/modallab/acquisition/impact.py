"""The impact test: at every point, wait for rest, ask for a blow, keep it, say whether it counts."""

from dataclasses import dataclass
from itertools import count

from modallab.acquisition.context import Context, measure_floor
from modallab.acquisition.hits import blow_of, refusals
from modallab.acquisition.rest import Floor, Rest, residual_ratio
from modallab.acquisition.trigger import Trigger
from modallab.errors import BenchError, BenchTimeoutError, SamplesLostError
from modallab.schema.events import HitRefused, HitWanted
from modallab.schema.plan import ImpactPlan
from modallab.storage import BlockNote

TELL_BLOCKS = 5
"""While the beam rings down, say so once in so many blocks."""


@dataclass(slots=True)
class ImpactTest:
    """One impact test on a started bench.

    Attributes:
        context: the bench.
        plan: points, hits, trigger, acceptance.
        floor: noise at rest.
        refused: refused blows at the present point.
        restarts: how often the bench had to be started anew.
    """

    context: Context
    plan: ImpactPlan
    floor: Floor
    refused: int = 0
    restarts: int = 0

    def run(self) -> None:
        """All points, all hits.

        Raises:
            BenchTimeoutError: no blow came in time.
            BenchError: too many blows at one point were refused.
            SamplesLostError: the device lost samples too often.
        """
        total = len(self.plan.points) * self.plan.hits
        for number, point in enumerate(self.plan.points):
            self.refused = 0
            for hit in range(1, self.plan.hits + 1):
                done = number * self.plan.hits + hit
                self._good_hit(point, hit, (done - 1, total))
                self.context.progress(done, total, f"point {point}, hit {hit} of {self.plan.hits}")

    def _good_hit(self, point: int, hit: int, progress: tuple[int, int]) -> None:
        refused_before = self.refused
        good = False
        while not good:
            try:
                good = self._hit(point, hit, self.refused - refused_before, progress)
            except SamplesLostError as error:
                self.restarts += 1
                self.context.restart(error, self.restarts)
                self._tell_refused(point, f"samples were lost: {error.what}; the bench was started anew")

    def _hit(self, point: int, hit: int, refused: int, progress: tuple[int, int]) -> bool:
        rest = self._wait_for_rest(progress)
        trigger = self._wait_for_blow(point, hit)
        first = trigger - self._pre_trigger
        self.context.stream.advance_to(first + self.context.block)
        return self._keep(point, (f"impact_p{point:02d}_{hit}", f"_refused_{refused + 1}"), first, rest)

    @property
    def _pre_trigger(self) -> int:
        return self.context.stream.samples_of(self.plan.pre_trigger_s)

    def _wait_for_rest(self, progress: tuple[int, int]) -> Rest:
        """Read until the beam rests, block by block; past the plan's patience go on with what there is."""
        context, stream = self.context, self.context.stream
        last = stream.next + stream.samples_of(self.plan.hit_timeout_s)
        for waited in count(1):
            rest = context.rest_now(self.floor)
            if rest.quiet or stream.next >= last:
                return rest
            if waited % TELL_BLOCKS == 0:
                context.progress(*progress, f"waiting for rest: {rest.line * context.line_hz:.4g} Hz still rings")
            stream.advance_to(stream.next + context.block)
        raise AssertionError("count never ends")

    def _wait_for_blow(self, point: int, hit: int) -> int:
        context, plan, stream = self.context, self.plan, self.context.stream
        if context.life.state == "arming":
            context.life.enter("armed")
        trigger = Trigger(plan.trigger_n, plan.hysteresis_n)
        last = stream.next + stream.samples_of(plan.hit_timeout_s)
        context.emit(HitWanted(run=context.recorder.run, point=point, hit=hit, of=plan.hits))
        context.bench.prompt_hit(point)
        while stream.next < last:
            chunk = stream.pull(stream.chunk)
            found = trigger.scan(context.chain.force_n(chunk.samples))
            if found is not None:
                if context.life.state == "armed":
                    context.life.enter("acquiring")
                return chunk.first_sample + found
        raise BenchTimeoutError(
            f"no blow above {plan.trigger_n:g} N at point {point} within {plan.hit_timeout_s:g} s",
            where=context.bench.info.url,
            remedy="strike harder, lower trigger_n, or look at the hammer's cable; the blocks before are kept",
        )

    def _keep(self, point: int, name: tuple[str, str], first: int, rest: Rest) -> bool:
        context = self.context
        samples = context.stream.cut(first, context.block)
        overload = context.stream.overload(first, context.block)
        blow = blow_of(
            context.chain.force_n(samples), context.stream.rate_hz, self._pre_trigger, self.plan.acceptance.min_band_hz
        )
        ratio, line = residual_ratio(
            context.motion(first - context.window, context.window), context.motion(first, context.block), self.floor
        )
        reasons = [*self._overloaded(overload), *refusals(blow, self.plan.acceptance), *self._ringing(ratio, line)]
        note = BlockNote(
            name="".join(name) if reasons else name[0],
            test="impact",
            first_sample=first,
            drive_point=point,
            accepted=not reasons,
            reason="; ".join(reasons),
            overload=overload,
            facts={
                "peak_n": blow.peak_n,
                "contact_s": blow.contact_s,
                "second_ratio": blow.second_ratio,
                "drop_db": blow.drop_db,
                "residual_ratio": ratio,
                "rest_level": rest.level,
                "rest_excess": rest.excess,
                "rest_line_hz": rest.line * context.line_hz,
            },
        )
        context.record(first, note)
        if reasons:
            self._refuse(point, note.reason)
        return not reasons

    def _overloaded(self, channels: tuple[str, ...]) -> list[str]:
        return [f"overload: {', '.join(channels)} beyond the range"] if channels else []

    def _ringing(self, ratio: float, line: int) -> list[str]:
        allowed = self.plan.acceptance.max_residual_ratio
        if ratio <= allowed:
            return []
        return [
            f"not at rest before: {100 * ratio:.3g} % of this blow at {line * self.context.line_hz:.4g} Hz,"
            f" at most {100 * allowed:g} %"
        ]

    def _refuse(self, point: int, reason: str) -> None:
        self.refused += 1
        self._tell_refused(point, reason)
        if self.refused > self.plan.max_refusals:
            raise BenchError(
                f"{self.refused} blows at point {point} were refused, the last one: {reason}",
                where=self.context.bench.info.url,
                remedy="change the tip, the place or the acceptance; the blocks are kept",
            )

    def _tell_refused(self, point: int, reason: str) -> None:
        self.context.emit(HitRefused(run=self.context.recorder.run, point=point, reason=reason))


def run_impact(context: Context, plan: ImpactPlan) -> None:
    """Measure the floor, then run the test; see `ImpactTest`."""
    ImpactTest(context, plan, measure_floor(context, plan.hit_timeout_s)).run()
