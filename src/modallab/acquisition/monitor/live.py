"""What the bench delivers, shown while it comes: for a look, never for the record.

A run's samples go into a ring in memory. Where it lies, and what is in it, stands in a small file beside the data, by
the run's name, which any process of this machine can read; it is gone with the run.
"""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from modallab.acquisition.monitor.ring_buffer import RingBuffer, RingBufferLayout, make_ring_buffer
from modallab.bench.protocol import DeliveredSampling, SampleChunk
from modallab.core.frozen import Frozen
from modallab.core.rig import Rig

FOLDER = "live"
IDLE = "idle-"
"""Begins the name under which a rig's signals are shown while no run is on."""
SECONDS = 10.0, 2.0
"""What a ring holds; the second where there is no memory for the first."""


class SampleCountRestart(Frozen):
    """Where the device's count of samples begins again: sample `position` of the ring is its `first_sample`."""

    position: int
    first_sample: int


class LiveInfo(Frozen):
    """What is in a ring.

    Attributes:
        run: the run, or `IDLE` and the bench.
        ring: path of the ring.
        capacity: samples per channel that it holds.
        rate_hz: sampling rate of the device.
        channels: names, rig order.
        scale: (channels,) unit per count.
        units: (channels,).
        dtype: of the samples, as NumPy writes it.
        breaks: the device's count; more than one where it was begun again.
    """

    run: str
    ring: str
    capacity: int
    rate_hz: float
    channels: tuple[str, ...]
    scale: tuple[float, ...]
    units: tuple[str, ...]
    dtype: str
    breaks: tuple[SampleCountRestart, ...] = ()

    def open(self) -> RingBuffer:
        """The ring, to read.

        Raises:
            OSError: it is gone.
        """
        return RingBuffer(Path(self.ring), RingBufferLayout(len(self.channels), self.capacity, self.dtype))


LiveTap = Callable[[SampleChunk], None]


class LiveRingBuffer:
    """The ring of one run, from the side that writes. Where there is no memory for it, nothing is shown."""

    def __init__(self, data_folder: Path) -> None:
        self._folder = data_folder / FOLDER
        self._ring: RingBuffer | None = None
        self._info: LiveInfo | None = None
        self._next = -1

    def open(self, run: str, rig: Rig, delivery: DeliveredSampling) -> LiveTap:
        """Make it for what a device delivers; returns what takes the chunks as they come."""
        ring = self._ring = _ring_shape(len(rig.channels), delivery)
        if ring is None:
            return _ignore_chunk
        self._info = LiveInfo(
            run=run,
            ring=str(ring.path),
            capacity=ring.shape.capacity,
            rate_hz=delivery.rate_hz,
            channels=tuple(channel.name for channel in rig.channels),
            scale=tuple(float(value) for value in delivery.scale),
            units=delivery.units,
            dtype=ring.shape.dtype,
        )
        return self._take

    def _take(self, chunk: SampleChunk) -> None:
        ring, info = self._ring, self._info
        assert ring is not None
        assert info is not None
        if chunk.first_sample != self._next:
            here = SampleCountRestart(position=ring.samples_written, first_sample=chunk.first_sample)
            self._info = info.model_copy(update={"breaks": (*info.breaks, here)})
            # A disk that takes no more keeps a look from nobody else's data.
            with suppress(OSError):
                self._publish(self._info)
        self._next = chunk.first_sample + chunk.samples.shape[1]
        ring.write(chunk.samples, chunk.overload)

    def _publish(self, info: LiveInfo) -> None:
        file = self._file(info.run)
        file.parent.mkdir(exist_ok=True)
        new = file.with_suffix(".new")
        new.write_text(info.model_dump_json())
        new.replace(file)

    def _file(self, run: str) -> Path:
        return self._folder / f"{run}.json"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        if self._ring is None or self._info is None:
            return
        self._file(self._info.run).unlink(missing_ok=True)
        self._ring.path.unlink(missing_ok=True)
        self._ring.close()


def live_info(data_folder: Path, run: str) -> LiveInfo | None:
    """What is shown of a run; None where nothing is: it has not begun to sample, or it has ended."""
    try:
        return LiveInfo.model_validate_json((data_folder / FOLDER / f"{run}.json").read_text())
    except (OSError, ValueError):
        return None


def remove_stale_ring_buffers(data_folder: Path, ended: Callable[[str], bool]) -> None:
    """Remove what processes that were killed left in memory; `ended` says of a name whether it is over."""
    for file in (data_folder / FOLDER).glob("*.json"):
        info = live_info(data_folder, file.stem)
        if info is not None and ended(info.run):
            Path(info.ring).unlink(missing_ok=True)
            file.unlink(missing_ok=True)


def _ring_shape(channels: int, delivery: DeliveredSampling) -> RingBuffer | None:
    for seconds in SECONDS:
        with suppress(OSError):
            return make_ring_buffer(RingBufferLayout.of_duration(channels, delivery.rate_hz, delivery.dtype, seconds))
    return None


def _ignore_chunk(_chunk: SampleChunk) -> None:
    """Nothing is shown."""
