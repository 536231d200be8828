"""The broadband test: random, burst-random, pseudo-random or chirp drive, blocks one after another without a gap."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import ceil

from modallab.acquisition.monitor.burst_watch import BurstWatch, burst_watch, channels_that_must_move
from modallab.acquisition.monitor.context import BufferedBlock, RunContext
from modallab.acquisition.monitor.run_states import DropBlock
from modallab.acquisition.monitor.wave_plausibility import WavePlausibility
from modallab.acquisition.procedures.broadband_checks import DrivenForces, driven_points, over_limits
from modallab.acquisition.procedures.broadband_wave import (
    WaveLayout,
    blocks_of_wave,
    blocks_per_wave,
    make_waves,
    peak_v,
    wave_layout,
)
from modallab.bench.capabilities import DrivesSeveralShakers, PlaysWaves
from modallab.bench.protocol import Bench, Waveform
from modallab.core.arrays import Real
from modallab.core.block import note_other_shakers
from modallab.core.errors import PlanError, SafetyError, SamplesLostError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Limits
from modallab.storage import BlockNote


@dataclass(frozen=True, eq=False, slots=True)
class _Wave:
    """What plays now.

    Attributes:
        level: of it.
        number: at this level, from 0.
        start: its first sample.
        layout: in time.
        waves: of each shaker that drives.
    """

    level: str
    number: int
    start: int
    layout: WaveLayout
    waves: Sequence[Waveform]


@dataclass(slots=True)
class BroadbandTest:
    """One broadband test on a started bench.

    Attributes:
        context: the bench.
        plan: signal, band, levels, blocks.
        limits: of the rig.
        watch: looks at the limits, and whether the channels can be believed.
        believed: the part of it that is to know what plays.
        forces: of the shakers that drive.
        points: where these stand, the first one's first.
        kept: names of the blocks that count, by level.
        waves: played so far, by level.
        rejected: blocks that did not count.
        restarts: how often the bench had to be started again.
    """

    context: RunContext
    plan: BroadbandPlan
    limits: Limits
    watch: BurstWatch
    believed: WavePlausibility
    forces: DrivenForces
    points: tuple[int, ...]
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
        self.context.life.enter_state("armed")
        self.context.life.enter_state("acquiring")
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
        stream.advance_to(stream.next + max(stream.samples_of(self.plan.wait_s), context.rest_window), self.watch)
        context.pause_if_requested(self.watch)
        rest = stream.copy_samples(stream.next - context.rest_window, context.rest_window)
        noise = self.watch.require_alive(rest, counts=stream.counts)
        rest_n = self.forces.rms(rest)
        number, self.waves[level] = self.waves[level], self.waves[level] + 1
        missing = self.plan.blocks - len(self.kept[level])
        most = blocks_per_wave(self.plan, self.limits.max_burst_s)
        fitting = blocks_of_wave(self.plan, number, missing, most, len(self.points))
        layout = wave_layout(self.plan, fitting, context.block / stream.rate_hz)
        waves = make_waves(self.plan, level, number, layout, len(self.points))
        if problems := over_limits(f"wave {number + 1} of {level}", waves, self.limits):
            raise PlanError("; ".join(problems), remedy="lower levels_v, or raise the rig's limits")
        context.excitation.on = True
        stream.poll()
        wave = _Wave(level, number, _start_of_waves(context.bench, waves), layout, waves)
        self.believed.begin(waves, wave.start, rest, noise, layout.block_s)
        held: list[BufferedBlock] = []
        try:
            while len(held) < fitting:
                held.append(self._take(wave, len(held), rest_n))
            stream.advance_to(wave.start + ceil(layout.end_s * stream.rate_hz) + 1, self.watch, context.driving_chunk)
        except BaseException as error:
            self._end_early(held, error, self._note(wave, len(held)))
            raise
        self.watch.end()
        context.excitation.on = False
        self._keep(held)
        self._require_patience(held)
        self._obey()

    def _end_early(self, held: list[BufferedBlock], error: BaseException, note: BlockNote) -> None:
        """End the drive, then keep what was recorded; what may hold the fault does not count."""
        context, stream = self.context, self.context.stream
        try:
            context.bench.zero()
        finally:
            self.watch.end()
            # A channel that is cut off may have been so for a while, in few samples, before it was found.
            doubt = f"in one wave with: {error}" if self.believed.failed else ""
            self._keep([_with_doubt(block, doubt) if doubt else block for block in held])
        if isinstance(error, SafetyError):
            first = stream.next - context.block
            overload = stream.overloaded_channels(first, context.block)
            name = f"{note.name}_tripped"
            context.record_block(
                first,
                replace(note, name=name, first_sample=first, accepted=False, reason=error.what, overload=overload),
            )

    def _keep(self, held: list[BufferedBlock]) -> None:
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
            self.context.report_progress(done, self.plan.blocks * len(self.kept), what)

    def _note(self, wave: _Wave, place: int) -> BlockNote:
        layout = wave.layout
        lead = self.context.stream.samples_of(layout.lead_s)
        return BlockNote(
            name=f"{self.plan.signal}_{wave.level}_{wave.number + 1:02d}_{place + 1:03d}",
            test=self.plan.signal,
            first_sample=wave.start + lead + place * self.context.block,
            drive_point=self.points[0],
            level=wave.level,
            facts={
                "drive_rms_v": self.plan.levels_v[wave.level],
                "drive_peak_v": max(map(peak_v, wave.waves)),
                "wave": float(wave.number + 1),
                "wave_first_sample": float(wave.start),
                "settle_s": layout.lead_s + place * layout.block_s,
                **note_other_shakers(self.points[1:]),
            },
        )

    def _take(self, wave: _Wave, place: int, rest_n: Real) -> BufferedBlock:
        """Read one block, and hold it until its wave is over."""
        context, stream, note = self.context, self.context.stream, self._note(wave, place)
        stream.advance_to(context.end_of(note.first_sample), self.watch, context.driving_chunk)
        block = stream.copy_samples(note.first_sample, context.block)
        self.forces.require_forces(block, rest_n, self.plan.levels_v[wave.level])
        first_s = (note.first_sample - wave.start) / stream.rate_hz
        self.forces.require_own_drive(block, wave.waves, first_s, stream.rate_hz)
        overload = stream.overloaded_channels(note.first_sample, context.block)
        reason = f"overload: {', '.join(overload)} beyond the range" if overload else ""
        held = replace(note, overload=overload, accepted=not overload, reason=reason)
        return context.block_to_write(note.first_sample, held)

    def _require_patience(self, held: list[BufferedBlock]) -> None:
        reasons = [block.note.reason for block in held if not block.note.accepted]
        if reasons and self.rejected > self.plan.max_rejections:
            raise PlanError(
                f"{self.rejected} blocks were rejected, the last one: {reasons[-1]}",
                remedy="lower the drive, or give the channel a larger range",
            )

    def _obey(self) -> None:
        for request in self.context.requests.take_all():
            if isinstance(request, DropBlock) and self.context.drop_block(request.block, request.reason):
                for names in self.kept.values():
                    if request.block in names:
                        names.remove(request.block)


def _start_of_waves(bench: Bench, waves: Sequence[Waveform]) -> int:
    """The sample at which the waves begin, one on each output."""
    if len(waves) > 1:
        assert isinstance(bench, DrivesSeveralShakers)
        return bench.play_waves(waves)
    assert isinstance(bench, PlaysWaves)
    return bench.play_wave(waves[0])


def _with_doubt(block: BufferedBlock, reason: str) -> BufferedBlock:
    return replace(block, note=replace(block.note, accepted=False, reason=reason))


def run_broadband(context: RunContext, plan: BroadbandPlan) -> None:
    """Run the test; see `BroadbandTest`."""
    limits = context.rig.limits
    if limits is None:
        raise PlanError("the rig has no limits", remedy="add limits to the rig file")
    watch = burst_watch(context.rig, limits, context.conversion, context.stream, plan.band_hz[0])
    points = driven_points(plan, context.rig)
    limited = channels_that_must_move(watch.limits, context.conversion, len(points))
    driven = context.conversion.forces[: len(points)]
    waves = WavePlausibility(context.conversion.names, driven, limited, context.stream.rate_hz)
    watch.waves = waves
    forces = DrivenForces(context.conversion, len(points))
    BroadbandTest(context, plan, limits, watch, waves, forces, points).run()
