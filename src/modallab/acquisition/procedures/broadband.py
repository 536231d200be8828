"""The broadband test: random, burst-random, pseudo-random or chirp drive, blocks one after another without a gap."""

from dataclasses import dataclass, field, replace
from math import ceil, inf

import numpy as np

from modallab.acquisition.monitor.burst_watch import BurstWatch, burst_watch
from modallab.acquisition.monitor.context import Context, HeldBlock
from modallab.acquisition.monitor.requests import DropBlock
from modallab.acquisition.monitor.wave_plausibility import WavePlausibility
from modallab.acquisition.procedures.broadband_wave import (
    Layout,
    blocks_a_wave,
    layout_of,
    peak_v,
    slew_v_per_s,
    wave_of,
)
from modallab.bench.protocol import Waveform, WavePlaying
from modallab.core.errors import PlanError, SafetyError, SamplesLostError, UnsupportedError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Limits, Rig
from modallab.storage import BlockNote

SEEN = 3.0
"""A force is one if it is so many times what its channel shows at rest."""


def longest_wave_s(plan: BroadbandPlan, limits: Limits | None) -> float:
    """How long the longest wave of a plan lasts, from 0 V to 0 V."""
    fitting = blocks_a_wave(plan, inf if limits is None else limits.max_burst_s)
    return layout_of(plan, fitting, plan.block_s).end_s


def wave_problems(plan: BroadbandPlan, limits: Limits) -> list[str]:
    """What the rig's limits do not allow of a plan's waves: each of them is looked at."""
    fitting = blocks_a_wave(plan, limits.max_burst_s)
    if not fitting:
        shortest_s = layout_of(plan, 1, plan.block_s).end_s
        return [f"a wave of one block lasts {shortest_s:.4g} s; allowed by the rig: {limits.max_burst_s:g} s"]
    layout = layout_of(plan, fitting, plan.block_s)
    problems: list[str] = []
    for level in plan.levels_v:
        waves = [wave_of(plan, level, number, layout) for number in range(ceil(plan.blocks / fitting))]
        problems += _over_limits(f"levels_v: {level}", waves, limits)
    return problems


def _over_limits(what: str, waves: list[Waveform], limits: Limits) -> list[str]:
    peak, slew = max(map(peak_v, waves)), max(map(slew_v_per_s, waves))
    found = [
        (f"{what} has a peak of {peak:.4g} V; allowed by the rig: {limits.drive_v:g} V", peak > limits.drive_v),
        (f"{what} slews {slew:.4g} V/s; allowed by the rig: {limits.slew_v_per_s:g} V/s", slew > limits.slew_v_per_s),
    ]
    return [text for text, over in found if over]


@dataclass(slots=True)
class BroadbandTest:
    """One broadband test on a started bench.

    Attributes:
        context: the bench.
        plan: signal, band, levels, blocks.
        limits: of the rig.
        watch: looks at the limits, and whether the channels can be believed.
        believed: the part of it that is to know what plays.
        kept: names of the blocks that count, by level.
        waves: played so far, by level.
        rejected: blocks that did not count.
        restarts: how often the bench had to be started again.
    """

    context: Context
    plan: BroadbandPlan
    limits: Limits
    watch: BurstWatch
    believed: WavePlausibility
    kept: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    waves: dict[str, int] = field(default_factory=dict[str, int])
    rejected: int = 0
    restarts: int = 0

    def run(self) -> None:
        """All levels, each until it has its blocks.

        Raises:
            SafetyError: a limit was exceeded.
            PlanError: too many blocks were rejected, or a wave is beyond the rig's limits.
            SamplesLostError: the device lost samples too often.
        """
        self.kept = {level: [] for level in self.plan.levels_v}
        self.waves = dict.fromkeys(self.plan.levels_v, 0)
        self.context.life.enter("armed")
        self.context.life.enter("acquiring")
        for level, names in self.kept.items():
            while len(names) < self.plan.blocks:
                try:
                    self._play(level)
                except SamplesLostError as error:
                    self.restarts += 1
                    self.context.restart(error, self.restarts)
                    self.watch.restart()
                    self.context.excitation.on = False

    def _play(self, level: str) -> None:
        """One wave, and the blocks in it."""
        context, stream = self.context, self.context.stream
        context.pause_if_requested(self.watch)
        stream.advance_to(stream.next + max(stream.samples_of(self.plan.wait_s), context.window), self.watch)
        context.pause_if_requested(self.watch)
        rest = stream.cut(stream.next - context.window, context.window)
        noise = self.watch.require_alive(rest, counts=stream.counts)
        rest_n = float(np.std(context.conversion.force_n(rest)))
        number, self.waves[level] = self.waves[level], self.waves[level] + 1
        missing = self.plan.blocks - len(self.kept[level])
        fitting = min(missing, blocks_a_wave(self.plan, self.limits.max_burst_s))
        layout = layout_of(self.plan, fitting, context.block / stream.rate_hz)
        wave = wave_of(self.plan, level, number, layout)
        if problems := _over_limits(f"wave {number + 1} of {level}", [wave], self.limits):
            raise PlanError("; ".join(problems), remedy="lower levels_v, or raise the rig's limits")
        context.excitation.on = True
        stream.poll()
        assert isinstance(context.bench, WavePlaying)
        start = context.bench.play_wave(wave)
        self.believed.begin(wave, start, rest, noise, layout.block_s)
        held: list[HeldBlock] = []
        try:
            while len(held) < fitting:
                held.append(self._take(self._note(level, number, len(held), start, layout, wave), rest_n))
            stream.advance_to(start + ceil(layout.end_s * stream.rate_hz) + 1, self.watch, context.driving_chunk)
        except BaseException as error:
            self._end_early(held, error, self._note(level, number, len(held), start, layout, wave))
            raise
        self.watch.end()
        context.excitation.on = False
        self._keep(held)
        self._require_patience(held)
        self._obey()

    def _end_early(self, held: list[HeldBlock], error: BaseException, note: BlockNote) -> None:
        """End the drive, then keep what was recorded; what may hold the fault does not count."""
        context, stream = self.context, self.context.stream
        try:
            context.bench.zero()
        finally:
            self.watch.end()
            # A channel that is cut off may have been so for a while, in few samples, before it was found.
            doubt = f"in one wave with: {error}" if self.believed.failed else ""
            self._keep([_doubted(block, doubt) if doubt else block for block in held])
        if isinstance(error, SafetyError):
            first = stream.next - context.block
            overload = stream.overload(first, context.block)
            name = f"{note.name}_tripped"
            context.record(
                first,
                replace(note, name=name, first_sample=first, accepted=False, reason=error.what, overload=overload),
            )

    def _keep(self, held: list[HeldBlock]) -> None:
        """Write the blocks of a wave that is over: a disk that is slow must not hold up the watch."""
        for block in held:
            note = block.note
            self.context.write(block)
            if note.accepted:
                self.kept[note.level or ""].append(note.name)
            else:
                self.rejected += 1
            done = sum(map(len, self.kept.values()))
            what = f"level {note.level}, {self.plan.signal}"
            self.context.progress(done, self.plan.blocks * len(self.kept), what)

    def _note(self, level: str, number: int, place: int, start: int, layout: Layout, wave: Waveform) -> BlockNote:
        lead = self.context.stream.samples_of(layout.lead_s)
        return BlockNote(
            name=f"{self.plan.signal}_{level}_{number + 1:02d}_{place + 1:03d}",
            test=self.plan.signal,
            first_sample=start + lead + place * self.context.block,
            drive_point=self.context.rig.shaker_point,
            level=level,
            facts={
                "drive_rms_v": self.plan.levels_v[level],
                "drive_peak_v": peak_v(wave),
                "wave": float(number + 1),
                "wave_first_sample": float(start),
                "settle_s": layout.lead_s + place * layout.block_s,
            },
        )

    def _take(self, note: BlockNote, rest_n: float) -> HeldBlock:
        """Read one block, and hold it until its wave is over."""
        context, stream = self.context, self.context.stream
        stream.advance_to(context.end_of(note.first_sample), self.watch, context.driving_chunk)
        self._require_force(note, rest_n)
        overload = stream.overload(note.first_sample, context.block)
        reason = f"overload: {', '.join(overload)} beyond the range" if overload else ""
        held = replace(note, overload=overload, accepted=not overload, reason=reason)
        return context.held(note.first_sample, held)

    def _require_force(self, note: BlockNote, rest_n: float) -> None:
        block = self.context.stream.cut(note.first_sample, self.context.block)
        force_n = float(np.std(self.context.conversion.force_n(block)))
        if force_n <= SEEN * rest_n:
            raise SafetyError(
                f"the force is {force_n:.3g} N rms while {self.plan.levels_v[note.level or '']:g} V rms drive, and"
                f" {rest_n:.3g} N at rest; the output was brought to 0 V",
                remedy="check the force sensor, the amplifier and the stinger, or drive harder",
            )

    def _require_patience(self, held: list[HeldBlock]) -> None:
        reasons = [block.note.reason for block in held if not block.note.accepted]
        if reasons and self.rejected > self.plan.max_rejections:
            raise PlanError(
                f"{self.rejected} blocks were rejected, the last one: {reasons[-1]}",
                remedy="lower the drive, or give the channel a larger range",
            )

    def _obey(self) -> None:
        for request in self.context.requests.take():
            if isinstance(request, DropBlock) and self.context.drop(request.block, request.reason):
                for names in self.kept.values():
                    if request.block in names:
                        names.remove(request.block)


def _doubted(block: HeldBlock, reason: str) -> HeldBlock:
    return replace(block, note=replace(block.note, accepted=False, reason=reason))


def run_broadband(context: Context, plan: BroadbandPlan) -> None:
    """Run the test; see `BroadbandTest`."""
    limits = context.rig.limits
    if limits is None:
        raise PlanError("the rig has no limits", remedy="add limits to the rig file")
    watch = burst_watch(context.rig, limits, context.conversion, context.stream, plan.band_hz[0])
    limited = [int(channel) for channel in np.flatnonzero(np.isfinite(watch.limits.limit))]
    waves = WavePlausibility(context.conversion.names, context.conversion.force, limited, context.stream.rate_hz)
    watch.waves = waves
    BroadbandTest(context, plan, limits, watch, waves).run()


def require_waves(plan: BroadbandPlan, bench: object, rig: Rig) -> None:
    """Reject a bench that cannot play waves, before anything moves.

    Raises:
        UnsupportedError: it cannot.
    """
    generator = rig.excitation is not None and rig.excitation.kind == "generator"
    if generator or not isinstance(bench, WavePlaying):
        raise UnsupportedError(
            f"{'a sine generator' if generator else 'this bench'} plays no {plan.signal} drive",
            where="broadband plan",
            remedy="drive by an analog output of the device, or run a sine test",
        )
