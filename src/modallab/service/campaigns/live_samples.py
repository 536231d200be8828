"""Live samples and their envelope, read from the rings of the runs that are on, for one viewer.

Every message is 4 bytes with the length of a JSON text (little-endian), the text, and an array (C order,
little-endian). A viewer that reads on from where it was misses nothing that is still in the ring; `lost` counts the
samples that are not.
"""

import json
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.live import FOLDER, IDLE, LiveInfo, live_info
from modallab.acquisition.monitor.ring_buffer import CELL, RingBuffer
from modallab.acquisition.process.idle_view import request_idle_view

WANT_S = 1.0
"""So often a viewer says that it still looks at rigs without a run."""
LARGEST_S = 0.5
"""A message holds at most so much: who was away catches up in several."""


def binary_message(about: dict[str, object], values: NDArray[Any]) -> bytes:
    """One binary message."""
    little = np.ascontiguousarray(values.astype(values.dtype.newbyteorder("<"), copy=False))
    text = json.dumps(about | {"dtype": little.dtype.str, "shape": little.shape}).encode()
    return b"".join((struct.pack("<I", len(text)), text, little.data))


@dataclass(frozen=True, slots=True)
class ViewSelection:
    """What a viewer wants to see.

    Attributes:
        rig: of this rig only; "" for all.
        run: of this run only; "" for all.
        channels: these only; none for all.
        after: of the first run shown: begin with this sample; None for now.
        idle: names under which rigs are shown while no run is on; none: runs only.
        columns_per_s: the extremes of so many stretches a second instead of samples; None for samples.
    """

    rig: str = ""
    run: str = ""
    channels: tuple[str, ...] = ()
    after: int | None = None
    columns_per_s: float | None = None
    idle: tuple[str, ...] = ()


@dataclass(eq=False, slots=True)
class LiveSource:
    """A run that is shown.

    Attributes:
        rig: it is on.
        info: what is in its ring.
        ring: the samples.
        rows: channels that are shown.
        next: position of the first sample that is not shown yet.
        ended: whether the run is over, so that nothing comes any more.
        written_ns: when `info` was written; 0 before the first look.
    """

    rig: str
    info: LiveInfo
    ring: RingBuffer
    rows: list[int]
    next: int
    ended: bool = False
    written_ns: int = 0

    def message_header(self, position: int, lost: int, *, ended: bool = False) -> dict[str, object]:
        """What stands at the beginning of every message."""
        info = self.info
        at = next((b for b in reversed(info.breaks) if b.position <= position), None)
        return {
            "rig": self.rig,
            "run": "" if info.run.startswith(IDLE) else info.run,
            "position": position,
            "first_sample": position if at is None else position - at.position + at.first_sample,
            "lost": lost,
            "rate_hz": info.rate_hz,
            "channels": [info.channels[row] for row in self.rows],
            "units": [info.units[row] for row in self.rows],
            "ended": ended,
        }

    def until_break(self, first: int, count: int) -> int:
        """So many of the next samples follow one another in the device's own count."""
        after = [b.position for b in self.info.breaks if b.position > first]
        return min(count, min(after) - first) if after else count


@dataclass(eq=False, slots=True)
class LiveView:
    """The runs one viewer looks at, and how far it has seen each.

    Attributes:
        folder: of the data.
        rig_of: the rig of a run.
        chosen: what it wants to see.
    """

    folder: Path
    rig_of: Callable[[str], str]
    chosen: ViewSelection
    _sources: dict[str, LiveSource] = field(default_factory=dict[str, LiveSource])
    _first: bool = True
    _wanted_s: float = float("-inf")

    def check_now(self) -> list[bytes]:
        """Messages with what is new; none where nothing is."""
        self._want()
        self._find()
        self._first = False
        step = _samples_of_source if self.chosen.columns_per_s is None else self._envelope
        return [found for source in list(self._sources.values()) for found in self._new(source, step)]

    def close(self) -> None:
        """Let go of the rings."""
        for source in self._sources.values():
            source.ring.close()

    def _want(self) -> None:
        now = time.monotonic()
        if self.chosen.idle and now - self._wanted_s > WANT_S:
            self._wanted_s = now
            for name in self.chosen.idle:
                request_idle_view(self.folder, name)

    def _envelope(self, source: LiveSource) -> bytes | None:
        assert self.chosen.columns_per_s is not None
        return _extremes_by_column(source, max(1, round(source.info.rate_hz / self.chosen.columns_per_s)))

    def _new(self, source: LiveSource, step: Callable[[LiveSource], bytes | None]) -> Iterator[bytes]:
        while (found := step(source)) is not None:
            yield found
        if source.ended:
            yield binary_message(
                source.message_header(source.next, 0, ended=True), np.zeros((len(source.rows), 0), source.info.dtype)
            )
            source.ring.close()
            del self._sources[source.info.run]

    def _find(self) -> None:
        on = {run: written_ns for run, written_ns in self._runs() if self.chosen.run in ("", run)}
        for run, source in self._sources.items():
            # What was written last is read once more after this.
            source.ended = run not in on
            # It is written again only where the device's count begins again, and looked for many times a second.
            if not source.ended and on[run] != source.written_ns:
                source.written_ns = on[run]
                source.info = live_info(self.folder, run) or source.info
        for run in on.keys() - self._sources.keys():
            self._open(run)

    def _runs(self) -> Iterator[tuple[str, int]]:
        """Each run that is shown, and when what is said of it was written."""
        for file in (self.folder / FOLDER).glob("*.json"):
            if file.stem.startswith(IDLE) and file.stem not in self.chosen.idle:
                continue
            # A run may end while it is looked for.
            with suppress(FileNotFoundError):
                yield file.stem, file.stat().st_mtime_ns

    def _open(self, run: str) -> None:
        info, rig = live_info(self.folder, run), self.rig_of(run)
        if info is None or self.chosen.rig not in ("", rig):
            return
        try:
            ring = info.open()
        except OSError:
            # The run has ended meanwhile.
            return
        rows = [i for i, name in enumerate(info.channels) if not self.chosen.channels or name in self.chosen.channels]
        # What began while the viewer looked is shown from its beginning.
        begin = (ring.samples_written if self.chosen.after is None else self.chosen.after) if self._first else 0
        self._sources[run] = LiveSource(rig, info, ring, rows, begin)


def _samples_of_source(source: LiveSource) -> bytes | None:
    info = source.info
    most = source.until_break(source.next, max(1, int(LARGEST_S * info.rate_hz)))
    first, samples, over = source.ring.read(source.next, most, source.rows)
    if not samples.shape[1]:
        return None
    lost, source.next = first - source.next, first + samples.shape[1]
    about = source.message_header(first, lost) | {
        "scale": [info.scale[row] for row in source.rows],
        "overload": [info.channels[row] for row, flags in zip(source.rows, over, strict=True) if flags.any()],
    }
    return binary_message(about, samples)


def _extremes_by_column(source: LiveSource, width: int) -> bytes | None:
    """Whole columns of `width` samples: (channels, 2, columns) least and largest value in each channel's unit."""
    info = source.info
    begin = -(-source.next // width) * width
    columns = min(source.ring.samples_written - begin, max(width, int(LARGEST_S * info.rate_hz))) // width
    if columns < 1:
        return None
    first, samples, over = source.ring.read(begin, columns * width, source.rows)
    if first != begin:
        # It went while it was read: on with the next column that is there.
        source.next = first
        return _extremes_by_column(source, width)
    lost, source.next = begin - source.next if begin - source.next >= width else 0, begin + columns * width
    values = samples.reshape(len(source.rows), columns, width)
    scale = np.array([info.scale[row] for row in source.rows])[:, None]
    ends = np.stack([values.min(axis=2) * scale, values.max(axis=2) * scale], axis=1)
    cells = (begin + np.arange(columns) * width) // CELL - begin // CELL
    about = source.message_header(begin, lost) | {
        "width": width,
        "overload": {
            info.channels[row]: np.flatnonzero(flags[cells]).tolist()
            for row, flags in zip(source.rows, over, strict=True)
        },
    }
    return binary_message(about, np.sort(ends, axis=1).astype(np.float32))
