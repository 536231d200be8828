"""The stepped sine test: every burst from rest, one block from its settled part, 0 V at its end."""

from collections import deque
from dataclasses import dataclass, field, replace
from math import ceil

from modallab.acquisition.monitor.burst_watch import BurstWatch, burst_watch
from modallab.acquisition.monitor.context import RunContext, measure_floor
from modallab.acquisition.monitor.settled import NoiseFloor, SettledCheck
from modallab.acquisition.procedures.burst import BurstCheck, BurstSetting, SineDrive, burst_of, check_burst
from modallab.acquisition.procedures.target import SineStep, repeated_steps, steps_of_plan
from modallab.bench.capabilities import ReportsOutput, SensorSupplyCheck
from modallab.core.documents.runs import RepeatFrequency
from modallab.core.errors import PlanError, SafetyError, SamplesLostError
from modallab.core.events import OperatorNotice
from modallab.core.plan import SinePlan
from modallab.core.rig import Limits
from modallab.storage import BlockNote

NOTIFY_BLOCKS = 5
"""While the beam rings down, say so once in so many blocks."""


@dataclass(slots=True)
class SineTest:
    """One sine test on a started bench.

    Attributes:
        context: the bench.
        plan: frequencies, levels, times.
        limits: of the rig.
        floor: noise at rest.
        watch: looks at the limits, and whether the channels can be believed.
        restarts: how often the bench had to be started again.
        todo: bursts that are still requested.
        kept: steps that were recorded, by the name of their record.
        drive: how hard.
    """

    context: RunContext
    plan: SinePlan
    limits: Limits
    floor: NoiseFloor
    watch: BurstWatch
    restarts: int = 0
    todo: deque[SineStep] = field(default_factory=deque[SineStep])
    kept: dict[str, SineStep] = field(default_factory=dict[str, SineStep])
    drive: SineDrive = field(init=False)

    def __post_init__(self) -> None:
        self.drive = SineDrive(self.plan, self.limits)

    def run(self) -> None:
        """All levels, all frequencies; one that is to be repeated comes next.

        Raises:
            SafetyError: a limit was exceeded.
            SamplesLostError: the device lost samples too often.
        """
        self.todo.extend(steps_of_plan(self.plan))
        self.context.life.enter_state("armed")
        self.context.life.enter_state("acquiring")
        while self.todo:
            step = self.todo.popleft()
            self._take(step)
            self.kept[step.name] = step
            if step.replaces and self.context.drop_block(step.replaces, f"repeated as {step.name}"):
                del self.kept[step.replaces]
            self._obey()
            self._notify(f"level {step.level}, {step.frequency_hz:.3f} Hz")

    def _notify(self, what: str) -> None:
        done = len(self.kept)
        self.context.report_progress(done, done + len(self.todo), what)

    def _obey(self) -> None:
        for request in self.context.requests.take_all():
            if isinstance(request, RepeatFrequency):
                self.todo.extendleft(repeated_steps(request, self.kept))
            elif self.context.drop_block(request.block, request.reason):
                self.kept.pop(request.block, None)

    def _take(self, step: SineStep) -> None:
        """Bursts at one frequency until one counts."""
        volts = self.drive.first_v(step.level, step.frequency_hz)
        setting: BurstSetting | None = BurstSetting(volts, self.plan.settle_s)
        while setting is not None:
            try:
                setting = self._burst(step, setting)
            except SamplesLostError as error:
                self.restarts += 1
                self.watch.restart()
                self.context.restart(error, self.restarts)
                self.context.excitation.on = False

    def _burst(self, step: SineStep, setting: BurstSetting) -> BurstSetting | None:
        """One burst from rest and its block; what to try next, or None if this one counts."""
        context, stream = self.context, self.context.stream
        context.pause_if_requested(self.watch)
        rest = self._wait_until_settled(step)
        # What was requested during the wait comes before the burst.
        context.pause_if_requested(self.watch)
        before = stream.copy_samples(stream.next - context.rest_window, context.rest_window)
        noise = self.watch.require_alive(before, counts=stream.counts)
        burst = burst_of(self.plan, step.frequency_hz, setting.volts, setting.settle_s)
        context.excitation.on = True
        stream.poll()
        start = context.bench.play(burst)
        self.watch.begin(burst, start, before, noise, stream.next)
        first = start + stream.samples_of(setting.settle_s)
        note = self._note(step, setting, start, first, rest)
        try:
            # Nothing is written before the output is at 0 V again: a disk that is slow must not hold up the watch.
            end = start + ceil(burst.duration_s * stream.rate_hz)
            stream.advance_to(end, self.watch, context.driving_chunk)
            context.excitation.on = False
            seen = check_burst(context, self.plan, self.watch, note, setting)
            self.watch.plausible.check_settled_force(step.frequency_hz, seen.measured.force_n, setting.volts)
            following = self._next(step, setting, seen)
        except SafetyError as error:
            context.bench.zero()
            self.watch.end()
            self._keep_tripped(note, error)
            raise
        self.watch.end()
        if isinstance(context.bench, ReportsOutput):
            note = replace(note, facts=note.facts | context.bench.output_facts())
        context.record_block(first, self._judged(note, seen, step, setting, rejected=following is not None))
        if following is None:
            self.drive.remember_good_voltage(step.level, seen.measured)
        return following

    def _wait_until_settled(self, step: SineStep) -> SettledCheck:
        """The plan's rest, and longer until the beam is at rest; past the plan's patience go on with what there is."""
        context, stream = self.context, self.context.stream
        last = stream.next + stream.samples_of(max(self.plan.wait_s, self.plan.settle_timeout_s))
        stream.advance_to(stream.next + stream.samples_of(self.plan.wait_s), self.watch)
        waited = 0
        while not (rest := context.check_settled_now(self.floor, self.watch)).is_settled and stream.next < last:
            waited += 1
            if waited % NOTIFY_BLOCKS == 0:
                ringing_hz = rest.line * context.line_hz
                self._notify(f"{step.frequency_hz:.3f} Hz waits for rest: {ringing_hz:.4g} Hz still rings")
            stream.advance_to(stream.next + context.block, self.watch)
        return rest

    def _note(self, step: SineStep, setting: BurstSetting, start: int, first: int, rest: SettledCheck) -> BlockNote:
        return BlockNote(
            name=step.name,
            test="sine",
            first_sample=first,
            drive_point=self.context.rig.shaker_point,
            level=step.level,
            frequency_hz=step.frequency_hz,
            facts={
                "burst_first_sample": float(start),
                "drive_v": setting.volts,
                "settle_s": setting.settle_s,
                **rest.facts(self.context.line_hz),
            },
        )

    def _next(self, step: SineStep, setting: BurstSetting, seen: BurstCheck) -> BurstSetting | None:
        """Another burst, where it may be better: longer, as the decay that was seen asks for, or at another drive."""
        longest = self.plan.max_settle_s or self.plan.settle_s
        settle_s, volts = setting.settle_s, setting.volts
        if seen.settled == "no":
            settle_s = min(longest, settle_s + seen.further_wait_s)
        if setting.number < (self.plan.force.max_bursts if self.plan.force is not None else 1):
            volts = self.drive.next_v(step.level, step.frequency_hz, seen.measured) or volts
        if settle_s <= setting.settle_s and volts == setting.volts:
            return None
        return BurstSetting(volts, settle_s, setting.number + 1)

    def _judged(
        self, note: BlockNote, seen: BurstCheck, step: SineStep, setting: BurstSetting, *, rejected: bool
    ) -> BlockNote:
        overload = self.context.stream.overloaded_channels(note.first_sample, self.context.block)
        reasons = [
            *([f"overload: {', '.join(overload)} beyond the range"] if overload else []),
            *([seen.unsettled] if seen.unsettled else []),
            *([error] if (error := self.drive.force_error(step.level, seen.measured)) else []),
        ]
        return replace(
            note,
            name=f"{note.name}_rejected_{setting.number}" if rejected else note.name,
            accepted=not rejected,
            overload=overload,
            reason="; ".join(reasons),
            facts=note.facts | seen.facts,
        )

    def _keep_tripped(self, note: BlockNote, error: SafetyError) -> None:
        first = self.context.stream.next - self.context.block
        tripped = replace(
            note,
            name=f"{note.name}_tripped",
            first_sample=first,
            accepted=False,
            reason=error.what,
            overload=self.context.stream.overloaded_channels(first, self.context.block),
        )
        self.context.record_block(first, tripped)


def run_sine(context: RunContext, plan: SinePlan) -> None:
    """Measure the floor, then run the test; see `SineTest`."""
    limits = context.rig.limits
    if limits is None:
        raise PlanError("the rig has no limits", remedy="add limits to the rig file")
    watch = burst_watch(context.rig, limits, context.conversion, context.stream, min(plan.frequencies_hz))
    floor = measure_floor(context, plan.wait_s, watch)
    _say_what_is_unseen(context)
    SineTest(context, plan, limits, floor, watch).run()


def _say_what_is_unseen(context: RunContext) -> None:
    unseen = context.bench.channels_without_open_detection() if isinstance(context.bench, SensorSupplyCheck) else ()
    if unseen:
        what = (
            f"the device cannot detect whether a sensor is connected to {', '.join(unseen)}: an unplugged sensor is "
            "detected only"
            " when it does not follow the drive"
        )
        context.emit(OperatorNotice(run=context.recorder.run, what=what))
