"""FRF and coherence of runs as far as they have come: every block is read and looked at once."""

from collections import OrderedDict
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.frf import UNIT, Frf
from modallab.core.rig import Rig
from modallab.core.units import FrfEstimator
from modallab.frf.broadband import PERIODIC, broadband_frf, driven_band
from modallab.frf.estimate import convert_frf
from modallab.frf.joined import contiguous_blocks
from modallab.frf.running import RunningFrf
from modallab.frf.stepped import SineLine, frf_of_lines, sine_line_of_block
from modallab.service.campaigns.live_samples import binary_message
from modallab.service.campaigns.runs import record_of
from modallab.service.context import Service
from modallab.service.errors import ConflictError
from modallab.signals.block_sets import ChosenOutputs
from modallab.signals.faults.whole_channels import overloaded_channels
from modallab.signals.signals import Signals, to_signals
from modallab.storage import Store


@dataclass(frozen=True, slots=True)
class FrfSelection:
    """What a viewer wants to see.

    Attributes:
        run: of this run.
        outputs: channel names; none for all.
        low_hz: lines from here.
        high_hz: up to here.
    """

    run: str
    outputs: tuple[str, ...]
    low_hz: float
    high_hz: float


@dataclass(eq=False, slots=True)
class FrfWatch:
    """One viewer of one run's FRFs.

    Attributes:
        service: that knows them.
        chosen: what is to be seen.
    """

    service: Service
    chosen: FrfSelection
    _known: bool = False
    _seen: dict[int | None, int] = field(default_factory=dict[int | None, int])

    def check_now(self) -> list[bytes]:
        """A message for each point whose FRF is another one than at the last look; none before the first block.

        Its array is (2, outputs, lines) complex64, mobility and coherence, the latter only where blocks are averaged.

        Raises:
            NotFoundError: there is no such run.
            DataError: there is no such output.
        """
        if not self._known:
            record_of(self.service, self.chosen.run)
            self._known = True
        try:
            self._seen, found = self.service.frfs().changed_points(self.chosen.run, self.chosen.outputs, self._seen)
        except ConflictError:
            return []
        return [self._message(frf) for frf in found]

    def _message(self, frf: Frf) -> bytes:
        chosen = self.chosen
        band = (frf.frequency_hz >= chosen.low_hz) & (frf.frequency_hz <= chosen.high_hz)
        parts = [frf.values[:, 0, band].astype(np.complex64)]
        if frf.coherence is not None:
            parts.append(frf.coherence[:, 0, band].astype(np.complex64))
        lines = frf.frequency_hz[band]
        about: dict[str, object] = {
            "run": chosen.run,
            "quantity": frf.quantity,
            "unit": UNIT[frf.quantity],
            "input_point": frf.input_points[0],
            "averages": frf.averages[0],
            "outputs": list(frf.outputs),
            "output_points": list(frf.output_points),
            "coherence": frf.coherence is not None,
            "frequency_hz": _axis_of_lines(lines),
        }
        return binary_message(about, np.stack(parts))


def _axis_of_lines(lines: "np.ndarray[tuple[int], np.dtype[np.float64]]") -> dict[str, float] | list[float]:
    """First line and step where the lines are evenly apart, else all of them."""
    step = (lines[-1] - lines[0]) / (lines.size - 1) if lines.size > 1 else 0.0
    if lines.size > 2 and np.allclose(np.diff(lines), step, rtol=1e-9):
        return {"first": float(lines[0]), "step": float(step), "count": float(lines.size)}
    return [float(line) for line in lines]


LOWEST_HZ = 0.5
LEAST_LINES = 2
USABLE = 0.4
"""Anti-alias filters hold the relation between channels up to this part of the rate."""

KEPT = 8
"""Runs, or sets of outputs of one run, whose sums are held; of another one all blocks are read again."""

Revisions = dict[int | None, int]


class LiveFrfs:
    """FRFs of the runs that were asked for last. From any thread."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._lock = Lock()
        self._runs: OrderedDict[tuple[str, ...], _FollowedRun] = OrderedDict()

    def frf(self, run: str, outputs: tuple[str, ...] = (), estimator: FrfEstimator = "H1") -> Frf:
        """Mobility of the blocks that count now, with coherence where blocks are averaged; of some outputs, or of all.

        Raises:
            ConflictError: there is no block that counts yet.
            DataError, StorageError: blocks that cannot be used, or not be read, an output that is not there, or H2 or
                Hv of single blocks or of sines.
        """
        followed = self._of(run, outputs)
        with followed.lock:
            followed.follow(self._store)
            return convert_frf(followed.sums.frf(followed.points, estimator), "mobility")

    def changed_points(self, run: str, outputs: tuple[str, ...], seen: Revisions) -> tuple[Revisions, list[Frf]]:
        """As `frf`, point by point, of the points whose FRF is another one than `seen`; and what is seen with them.

        The revision of a point grows when its FRF changes.
        """
        followed = self._of(run, outputs)
        with followed.lock:
            followed.follow(self._store)
            now = dict(followed.revisions)
            changed = [point for point in followed.points if seen.get(point) != now[point]]
            return now, [convert_frf(followed.sums.frf((point,)), "mobility") for point in changed]

    def _of(self, run: str, outputs: tuple[str, ...]) -> "_FollowedRun":
        key = run, *sorted(outputs)
        with self._lock:
            if key not in self._runs:
                record = self._store.catalogue.run(run)
                chosen = ChosenOutputs.of(record.rig, outputs)
                made = {"impact": _HitSums, "sine": _SineLines}.get(record.test, _BroadbandBlocks)
                self._runs[key] = _FollowedRun(run, record.rig, chosen, made(chosen.rig))
            self._runs.move_to_end(key)
            while len(self._runs) > KEPT:
                self._runs.popitem(last=False)
            return self._runs[key]


class _FollowedRun:
    """One run: which of its blocks were looked at, and where each was driven."""

    def __init__(
        self, run: str, rig: Rig, chosen: ChosenOutputs, sums: "_HitSums | _SineLines | _BroadbandBlocks"
    ) -> None:
        self.run, self.sums, self.lock = run, sums, Lock()
        self.revisions: Revisions = {}
        self._rig, self._chosen = rig, chosen
        self._seen: dict[int, int | None] = {}
        self._added: set[int] = set()

    @property
    def points(self) -> tuple[int | None, ...]:
        """Points that have blocks in the sums, in the order of time."""
        return tuple(dict.fromkeys(self._seen[n] for n in sorted(self._added)))

    def follow(self, store: Store) -> None:
        """Look at what is new."""
        rows = {row.n: row.note.drive_point for row in store.catalogue.blocks(self.run) if row.note.accepted}
        counted = rows.keys()
        gone = self._seen.keys() - counted
        back = {n for n in counted - self._seen.keys() if self._seen and n < max(self._seen)}
        # Such a point is summed again: what was added cannot be taken away to the last digit, nor put between others.
        changed = {self._seen[n] for n in gone} | {rows[n] for n in back}
        self.sums.forget(gone, changed)
        self._seen = {n: point for n, point in self._seen.items() if point not in changed}
        self._added &= self._seen.keys()
        for block in store.iterate_blocks(self.run, numbers=counted - self._seen.keys()):
            self._seen[block.order] = block.drive_point
            # A block with any channel at full scale counts nowhere, whichever channels are looked at.
            if not overloaded_channels(block, self._rig):
                self.sums.add(self._chosen.block(block))
                self._added.add(block.order)
                changed.add(block.drive_point)
        for point in changed:
            self.revisions[point] = self.revisions.get(point, 0) + 1
        if self.sums.empty:
            raise ConflictError(
                f"run {self.run} has not enough good blocks for an FRF yet",
                where=self.run,
                remedy="wait for the next good block",
            )


class _HitSums:
    """Of an impact test."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._running: RunningFrf | None = None

    @property
    def empty(self) -> bool:
        return self._running is None or not self._running.points

    def add(self, block: Block) -> None:
        signals = to_signals(block, self._rig)
        if self._running is None:
            self._running = RunningFrf(self._rig, signals, (LOWEST_HZ, USABLE * block.rate_hz))
        self._running.add_hit(signals)

    def forget(self, _numbers: set[int], points: set[int | None]) -> None:
        if self._running is not None:
            for point in points:
                self._running.remove_point(point)

    def frf(self, points: tuple[int | None, ...] | None, estimator: FrfEstimator = "H1") -> Frf:
        assert self._running is not None
        return self._running.frf(points, estimator)


class _SineLines:
    """Of a sine test: one level only, the last one's, since FRFs of levels are what is compared, never averaged."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._lines: dict[int, tuple[str | None, SineLine]] = {}

    @property
    def empty(self) -> bool:
        # One line alone is no FRF yet.
        return len(self._of_last_level()) < LEAST_LINES

    def add(self, block: Block) -> None:
        self._lines[block.order] = block.level, sine_line_of_block(to_signals(block, self._rig), self._rig)

    def forget(self, numbers: set[int], _points: set[int | None]) -> None:
        for n in numbers:
            self._lines.pop(n, None)

    def frf(self, _points: tuple[int | None, ...] | None, estimator: FrfEstimator = "H1") -> Frf:
        if estimator != "H1":
            raise DataError(
                f"there is no {estimator} of sines: their FRF is the ratio of two fitted amplitudes",
                remedy="leave the estimator out",
            )
        return frf_of_lines(self._of_last_level(), self._rig)

    def _of_last_level(self) -> list[SineLine]:
        last = self._lines[max(self._lines)][0] if self._lines else None
        return [line for level, line in self._lines.values() if level == last]


class _BroadbandBlocks:
    """Of a broadband test: the last level's blocks, all of which are read again when one comes or goes."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._signals: dict[int, Signals] = {}

    @property
    def empty(self) -> bool:
        """Several forces cannot be distinguished before as many waves have come, of a drive that repeats."""
        several = max((len(s.forces) for s in self._signals.values()), default=1)
        waves = contiguous_blocks(list(self._signals.values()))
        periodic = any(s.block.test in PERIODIC for s in self._signals.values())
        return len(self._signals) < several + (several > 1) or (periodic and len(waves) < several)

    def add(self, block: Block) -> None:
        self._signals[block.order] = to_signals(block, self._rig)

    def forget(self, numbers: set[int], _points: set[int | None]) -> None:
        for n in numbers:
            self._signals.pop(n, None)

    def frf(self, _points: tuple[int | None, ...] | None, estimator: FrfEstimator = "H1") -> Frf:
        level = self._signals[max(self._signals)].block.level
        chosen = [s for s in self._signals.values() if s.block.level == level]
        return broadband_frf(chosen, self._rig, driven_band(chosen), estimator=estimator)
