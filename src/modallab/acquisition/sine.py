"""The stepped sine test: every burst from rest, one block from its settled part, 0 V at its end."""

from dataclasses import dataclass, replace
from math import ceil

from modallab.acquisition.context import Context, measure_floor
from modallab.acquisition.limits import watch_of
from modallab.acquisition.rest import Floor
from modallab.acquisition.stream import Watch
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


def block_name(level: str, frequency_hz: float) -> str:
    """Name of a sine record."""
    return f"sine_{level}_{frequency_hz:07.3f}"


@dataclass(slots=True)
class SineTest:
    """One sine test on a started bench.

    Attributes:
        context: the bench.
        plan: frequencies, levels, times.
        floor: noise at rest.
        watch: looks at the limits.
        restarts: how often the bench had to be started anew.
    """

    context: Context
    plan: SinePlan
    floor: Floor
    watch: Watch
    restarts: int = 0

    def run(self) -> None:
        """All levels, all frequencies.

        Raises:
            SafetyError: a limit was exceeded.
            SamplesLostError: the device lost samples too often.
        """
        steps = [(level, volts, f) for level, volts in self.plan.levels_v.items() for f in self.plan.frequencies_hz]
        self.context.life.enter("armed")
        self.context.life.enter("acquiring")
        for done, (level, volts, frequency) in enumerate(steps, start=1):
            while not self._try(level, volts, frequency):
                pass
            self.context.progress(done, len(steps), f"level {level}, {frequency:.3f} Hz")

    def _try(self, level: str, volts: float, frequency_hz: float) -> bool:
        try:
            self._step(level, volts, frequency_hz)
        except SamplesLostError as error:
            self.restarts += 1
            self.context.restart(error, self.restarts)
            return False
        return True

    def _step(self, level: str, volts: float, frequency_hz: float) -> None:
        context, stream = self.context, self.context.stream
        stream.advance_to(stream.next + stream.samples_of(self.plan.rest_s), self.watch)
        rest = context.rest_now(self.floor, self.watch)
        burst = burst_of(self.plan, frequency_hz, volts)
        start = context.bench.play(burst)
        first = start + stream.samples_of(self.plan.settle_s)
        note = BlockNote(
            name=block_name(level, frequency_hz),
            test="sine",
            first_sample=first,
            drive_point=context.rig.shaker_point,
            level=level,
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


def run_sine(context: Context, plan: SinePlan) -> None:
    """Measure the floor, then run the test; see `SineTest`."""
    limits = context.rig.limits
    if limits is None:
        raise PlanError("the rig has no limits", remedy="add limits to the rig file")
    watch = watch_of(context.rig, limits, context.chain)
    SineTest(context, plan, measure_floor(context, plan.rest_s, watch), watch).run()
