"""The stepped sine test: every burst from rest, one block from its settled part, 0 V at its end."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import ceil

from modallab.acquisition.context import Context, measure_floor
from modallab.acquisition.limits import watch_of
from modallab.acquisition.rest import Floor
from modallab.acquisition.stream import Watch
from modallab.acquisition.target import Step
from modallab.acquisition.wishes import Repeat
from modallab.backend.protocol import Burst
from modallab.errors import PlanError, SafetyError, SamplesLostError
from modallab.schema.plan import SinePlan
from modallab.storage import BlockNote

HOLD_MARGIN_S = 0.1
"""Past the block's end: a converter delays its samples by up to some 40 periods of its rate."""


def burst_of(plan: SinePlan, frequency_hz: float, amplitude_v: float) -> Burst:
    """The burst whose settled part holds the block."""
    hold = plan.settle_s - plan.ramp_s + plan.block_s + HOLD_MARGIN_S
    return Burst(frequency_hz, amplitude_v, plan.ramp_s, hold)


def longest_burst_s(plan: SinePlan) -> float:
    """How long the longest burst of a plan lasts, from 0 V to 0 V."""
    return burst_of(plan, 1.0, 1.0).duration_s


@dataclass(slots=True)
class SineTest:
    """One sine test on a started bench.

    Attributes:
        context: the bench.
        plan: frequencies, levels, times.
        floor: noise at rest.
        watch: looks at the limits.
        restarts: how often the bench had to be started anew.
        todo: bursts that are still wanted.
        kept: steps that were recorded, by the name of their record.
    """

    context: Context
    plan: SinePlan
    floor: Floor
    watch: Watch
    restarts: int = 0
    todo: deque[Step] = field(default_factory=deque[Step])
    kept: dict[str, Step] = field(default_factory=dict[str, Step])

    def run(self) -> None:
        """All levels, all frequencies; one that is to be repeated comes next.

        Raises:
            SafetyError: a limit was exceeded.
            SamplesLostError: the device lost samples too often.
        """
        self.todo.extend(Step(level, f) for level in self.plan.levels_v for f in self.plan.frequencies_hz)
        self.context.life.enter("armed")
        self.context.life.enter("acquiring")
        while self.todo:
            step = self.todo.popleft()
            while not self._try(step):
                pass
            self.kept[step.name] = step
            if step.replaces and self.context.drop(step.replaces, f"repeated as {step.name}"):
                del self.kept[step.replaces]
            self._obey()
            self._tell(step)

    def _tell(self, step: Step) -> None:
        done = len(self.kept)
        self.context.progress(done, done + len(self.todo), f"level {step.level}, {step.frequency_hz:.3f} Hz")

    def _obey(self) -> None:
        for request in self.context.wishes.take():
            if isinstance(request, Repeat):
                self.todo.extendleft(again(request, self.kept))
            elif self.context.drop(request.block, request.reason):
                self.kept.pop(request.block, None)

    def _try(self, step: Step) -> bool:
        try:
            self.context.pause_if_wanted(self.watch)
            self._step(step)
        except SamplesLostError as error:
            self.restarts += 1
            self.context.restart(error, self.restarts)
            return False
        return True

    def _step(self, step: Step) -> None:
        context, stream = self.context, self.context.stream
        stream.advance_to(stream.next + stream.samples_of(self.plan.rest_s), self.watch)
        rest = context.rest_now(self.floor, self.watch)
        # What was wished for in the rest comes before the burst.
        context.pause_if_wanted(self.watch)
        volts, frequency_hz = self.plan.levels_v[step.level], step.frequency_hz
        burst = burst_of(self.plan, frequency_hz, volts)
        start = context.bench.play(burst)
        first = start + stream.samples_of(self.plan.settle_s)
        note = BlockNote(
            name=step.name,
            test="sine",
            first_sample=first,
            drive_point=context.rig.shaker_point,
            level=step.level,
            frequency_hz=frequency_hz,
            facts={"burst_first_sample": float(start), **rest.facts(context.line_hz)},
        )
        try:
            stream.advance_to(first + context.block, self.watch)
        except SafetyError as error:
            context.bench.zero()
            self._keep_tripped(note, error)
            raise
        context.record(first, self._flagged(note))
        stream.advance_to(start + ceil(burst.duration_s * stream.rate_hz), self.watch)

    def _flagged(self, note: BlockNote) -> BlockNote:
        overload = self.context.stream.overload(note.first_sample, self.context.block)
        reason = f"overload: {', '.join(overload)} beyond the range" if overload else ""
        return replace(note, overload=overload, reason=reason)

    def _keep_tripped(self, note: BlockNote, error: SafetyError) -> None:
        first = self.context.stream.next - self.context.block
        tripped = replace(
            note,
            name=f"{note.name}_tripped",
            first_sample=first,
            accepted=False,
            reason=error.what,
            overload=self.context.stream.overload(first, self.context.block),
        )
        self.context.record(first, tripped)


def again(request: Repeat, kept: Mapping[str, Step]) -> list[Step]:
    """The steps a request asks for, out of those that were kept."""
    return [
        replace(step, again=step.again + 1, replaces=name)
        for name, step in kept.items()
        if round(step.frequency_hz, 3) == round(request.frequency_hz, 3) and request.level in ("", step.level)
    ]


def run_sine(context: Context, plan: SinePlan) -> None:
    """Measure the floor, then run the test; see `SineTest`."""
    limits = context.rig.limits
    if limits is None:
        raise PlanError("the rig has no limits", remedy="add limits to the rig file")
    watch = watch_of(context.rig, limits, context.chain)
    SineTest(context, plan, measure_floor(context, plan.rest_s, watch), watch).run()
