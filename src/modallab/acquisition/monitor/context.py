"""What a running test has at hand."""

import time
from concurrent.futures import Future
from dataclasses import dataclass, field, replace

from modallab.acquisition.monitor.run_states import Emit, ExcitationState, OperatorRequests, RunLifecycle
from modallab.acquisition.monitor.settled import (
    NoiseFloor,
    SettledCheck,
    Window,
    WindowLevels,
    check_settled,
    motion_decays,
    noise_floor_of_windows,
)
from modallab.acquisition.monitor.stream import BenchStream, Watch
from modallab.bench.protocol import Bench
from modallab.bench.resampling import ResamplingRule
from modallab.core.errors import SamplesLostError
from modallab.core.events import BlockAccepted, BlockAcknowledged, BlockDropped, RunProgress
from modallab.core.rig import Rig
from modallab.signals.conversion import Conversion
from modallab.signals.transform import next_quick_length
from modallab.storage import BlockNote, Recorder
from modallab.storage.recorder import SamplesInFile
from modallab.storage.samples import Samples

FLOOR_WINDOWS = 4
"""Windows the noise floor is taken from."""

PAUSE_LOOK_S = 0.02
"""Between two looks whether a pause is over, where time is virtual and does not go on by itself."""

MAX_RESTARTS = 3
"""Gaps a run survives; a machine that loses samples more often is not fit for the rate."""

DRIVING_CHUNK_S = 0.02
"""What is beyond a limit is seen so much later, at most, than it happens."""

WINDOW_BLOCKS = 2
"""Blocks a window for the look at rest is long, at least: twice the block, for lines half as wide."""


@dataclass(frozen=True, eq=False, slots=True)
class BufferedBlock:
    """A block in memory: while the output is on, nothing is written.

    Attributes:
        samples: (channels, n) as delivered, with the ends that a change of rate needs.
        note: what is known about it.
    """

    samples: Samples
    note: BlockNote


@dataclass(frozen=True, eq=False, slots=True)
class RunContext:
    """A configured, started bench and where its data go.

    Attributes:
        bench: streaming.
        rig: as believed.
        recorder: open.
        emit: takes the events.
        life: the run's state.
        conversion: from the device's numbers to SI, and full scale.
        stream: its samples.
        block: samples of a block, as the device counts.
        recut: how blocks are read back at another rate than the device's; None if at its own.
        requests: what the owner wants besides.
        excitation: says whether a burst may be on.
    """

    bench: Bench
    rig: Rig
    recorder: Recorder
    emit: Emit
    life: RunLifecycle
    conversion: Conversion
    stream: BenchStream
    block: int
    recut: ResamplingRule | None = None
    requests: OperatorRequests = field(default_factory=OperatorRequests)
    excitation: ExcitationState = field(default_factory=ExcitationState)

    @property
    def rest_window(self) -> int:
        """Samples of a window for the look at rest; a block's own number may take the transform three times as long."""
        return next_quick_length(WINDOW_BLOCKS * self.block)

    @property
    def driving_chunk(self) -> int:
        """Samples to read at once while a burst is on: few, where they come at the pace of the clock on the wall."""
        chunk = self.stream.chunk
        return min(chunk, max(1, self.stream.samples_of(DRIVING_CHUNK_S))) if self.bench.info.real_time else chunk

    @property
    def line_hz(self) -> float:
        """Width of a window's line."""
        return self.stream.rate_hz / self.rest_window

    def motion_samples(self, first: int, count: int) -> Window:
        """(motion channels, count) of a remembered stretch, as delivered; a view where they stand side by side."""
        rows, stretch = self.conversion.motion, self.stream.view_samples(first, count)
        if rows and rows == tuple(range(rows[0], rows[-1] + 1)):
            return stretch[rows[0] : rows[-1] + 1]
        return stretch[list(rows)]

    def look_at_last_window(self, floor: NoiseFloor, watch: Watch | None = None) -> WindowLevels:
        """At the last window; after a restart it must first be read."""
        self.stream.advance_to(self.rest_window, watch)
        return WindowLevels.of(self.motion_samples(self.stream.next - self.rest_window, self.rest_window), floor.rms)

    def check_settled_now(self, floor: NoiseFloor, watch: Watch | None = None) -> SettledCheck:
        """What the last window says."""
        return check_settled(self.look_at_last_window(floor, watch), floor)

    def restart(self, after: SamplesLostError, restarts: int) -> None:
        """Bring the output to zero and start the bench again after a gap; what came before it is never spliced.

        Raises:
            SamplesLostError: `after`, once it happened too often.
        """
        self.bench.zero()
        if restarts > MAX_RESTARTS:
            raise after
        self.stream.restart()

    def record_block(self, first: int, note: BlockNote) -> BlockAcknowledged:
        """Keep the block from sample `first` and report that it is kept."""
        return self.write(self.block_to_write(first, note))

    def end_of(self, first: int) -> int:
        """The sample (exclusive) up to which a block from `first` must be read before it can be held."""
        return first + (self.block if self.recut is None else max(self.block, self.recut.native - self.recut.lead))

    def block_to_write(self, first: int, note: BlockNote) -> "BufferedBlock":
        """The block from sample `first`, as it will be written."""
        return BufferedBlock(self._cut(first), self._noted(first, note))

    def place_block(self, first: int) -> Future[SamplesInFile]:
        """Begin to write the samples of the block from sample `first`, while it is still looked at."""
        return self.recorder.place_block(self._cut(first))

    def keep_block(self, first: int, placed: Future[SamplesInFile], note: BlockNote) -> BlockAcknowledged:
        """Keep a placed block, with what is known of it by now, and report that it is kept."""
        kept = self.recorder.keep_block(placed, self._noted(first, note))
        self.emit(kept)
        return kept

    def _cut(self, first: int) -> Samples:
        if self.recut is None:
            return self.stream.copy_samples(first, self.block)
        # The ends the new samples lean on are kept too.
        self.stream.advance_to(first + self.recut.native - self.recut.lead)
        return self.stream.copy_samples(first - self.recut.lead, self.recut.native)

    def _noted(self, first: int, note: BlockNote) -> BlockNote:
        if self.recut is None:
            return note
        # Looked at for clipping before anything is resampled.
        ends = self.stream.overloaded_channels(first - self.recut.lead, self.recut.native)
        return replace(note, overload=ends, facts=note.facts | self.recut.facts())

    def write(self, block: "BufferedBlock") -> BlockAcknowledged:
        """Keep a block and report that it is kept."""
        kept = self.recorder.record_block(block.samples, block.note)
        self.emit(kept)
        return kept

    @property
    def pause_requested(self) -> bool:
        """Whether the test should go to its next boundary and pause there; before the first block it cannot."""
        return self.requests.pause_requested and self.life.state in ("acquiring", "paused")

    def pause_if_requested(self, watch: Watch | None = None) -> None:
        """At a boundary: while a pause is requested, keep the output at 0 V and go on reading and watching."""
        if self.pause_requested and self.life.state == "acquiring":
            self.bench.zero()
            self.life.enter_state("paused", "paused by the operator")
        if self.life.state != "paused":
            return
        while self.requests.pause_requested:
            self.watch_while_waiting(watch)
        self.life.enter_state("acquiring", "resumed by the operator")

    def watch_while_waiting(self, watch: Watch | None = None) -> None:
        """Let a short time pass, with the limits watched, while an operator is waited for."""
        if self.bench.info.real_time:
            # What the device delivers must be taken, or its buffer would run over.
            self.stream.advance_to(self.stream.next + self.stream.chunk, watch)
        else:
            self.stream.poll()
            time.sleep(PAUSE_LOOK_S)

    def drop_block(self, name: str, reason: str) -> bool:
        """Let a block no longer count, and report it; whether there was one that did."""
        dropped = self.recorder.drop_block(name, reason)
        if dropped:
            self.emit(BlockDropped(run=self.recorder.run, name=name, reason=reason))
        return dropped

    def accept_block(self, name: str, reason: str, operator: str) -> bool:
        """Let a block that was rejected count, and report it; whether there was one."""
        accepted = self.recorder.accept_block(name, reason, operator)
        if accepted:
            self.emit(BlockAccepted(run=self.recorder.run, name=name, reason=reason))
        return accepted

    def report_progress(self, done: int, total: int, what: str) -> None:
        """Report how far the run is."""
        self.emit(RunProgress(run=self.recorder.run, done=done, total=total, what=what))


def measure_floor(context: RunContext, patience_s: float, watch: Watch | None = None) -> NoiseFloor:
    """The noise floor at the start; if the beam still rings then, wait until it no longer fades, up to `patience_s`."""
    stream = context.stream
    last = stream.next + stream.samples_of(patience_s)
    while True:
        start = stream.next
        windows: list[Window] = []
        for end in range(
            start + context.rest_window, start + FLOOR_WINDOWS * context.rest_window + 1, context.rest_window
        ):
            stream.advance_to(end, watch)
            windows.append(context.motion_samples(end - context.rest_window, context.rest_window).copy())
        floor = noise_floor_of_windows(windows, counts=stream.counts)
        if stream.next >= last or not motion_decays(windows, floor):
            return floor
