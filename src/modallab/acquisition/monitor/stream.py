"""The samples of a running bench, without a gap, with a memory of the last few seconds."""

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Bench, DeliveredSampling, SampleChunk
from modallab.core.errors import SamplesLostError
from modallab.signals.conversion import Conversion
from modallab.storage.samples import Samples

Watch = Callable[[SampleChunk], None]

READ_SLACK_S = 5.0


class BenchStream:
    """Reads a started bench up to requested places and cuts stretches out of what was read.

    Everything is addressed by the device's own sample count, so what is cut never depends on how it was read.
    """

    def __init__(
        self,
        bench: Bench,
        delivery: DeliveredSampling,
        conversion: Conversion,
        *,
        keep: int,
        chunk: int,
        poll: Callable[[], None],
        tap: Watch | None = None,
    ) -> None:
        """Follow `bench`; remember `keep` samples, read at most `chunk` at once, call `poll` before every read.

        `tap` sees every chunk after it, to show it to others.
        """
        self.rate_hz = delivery.rate_hz
        self.counts = delivery.dtype.kind in "iu"
        self.scale = delivery.scale
        self.next = 0
        self.chunk = chunk
        self._bench = bench
        self._conversion = conversion
        self._keep = keep
        self._poll = poll
        self._tap = tap
        self._buffer = np.zeros((len(delivery.units), 2 * (keep + chunk)), dtype=delivery.dtype)
        self._filled = 0
        self._overloads: deque[tuple[int, int, NDArray[np.bool_]]] = deque()

    def restart(self) -> None:
        """Stop and start the bench: the count begins at 0 again, and what was before is forgotten."""
        self._bench.stop()
        self._bench.start()
        self.next = self._filled = 0
        self._overloads.clear()

    def replace_by_record(self, record: SampleChunk) -> None:
        """Remember a record the device has triggered by itself, in place of what was before; its count begins at 0."""
        self.next = self._filled = 0
        self._overloads.clear()
        self._remember(record)

    def samples_of(self, seconds: float) -> int:
        """Whole number of samples nearest to a duration."""
        return round(seconds * self.rate_hz)

    def poll(self) -> None:
        """Look whether the run shall go on, as is done before every read."""
        self._poll()

    def read_samples(self, count: int) -> SampleChunk:
        """The next `count` samples, at most `chunk`.

        Raises:
            SamplesLostError: the device's count jumped.
            BenchError: what the bench raised.
        """
        self._poll()
        count = min(count, self.chunk)
        chunk = self._bench.read(count, count / self.rate_hz + READ_SLACK_S)
        if chunk.first_sample != self.next:
            raise SamplesLostError(
                f"sample {chunk.first_sample} arrived instead of sample {self.next}",
                where=self._bench.info.url,
                remedy="start a new run; blocks before the gap are kept",
            )
        self._remember(chunk)
        if self._tap is not None:
            self._tap(chunk)
        return chunk

    def advance_to(self, sample: int, watch: Watch | None = None, at_once: int | None = None) -> None:
        """Read up to `sample` (exclusive), `at_once` samples or a chunk a read; `watch` sees every chunk.

        Nothing to do if it is already read.
        """
        while self.next < sample:
            chunk = self.read_samples(min(sample - self.next, at_once or self.chunk))
            if watch is not None:
                watch(chunk)

    def copy_samples(self, first: int, count: int) -> Samples:
        """A copy of (channels, count) samples from `first`, which must still be remembered."""
        return self.view_samples(first, count).copy()

    def view_samples(self, first: int, count: int) -> Samples:
        """As `cut`, to be looked at before the next read and not changed; a copy of many channels takes its time."""
        start = self._filled - (self.next - first)
        if start < 0 or first + count > self.next:
            raise IndexError(f"samples {first} to {first + count} are not in memory, which ends at {self.next}")
        found = self._buffer[:, start : start + count]
        found.flags.writeable = False
        return found

    def overloaded_channels(self, first: int, count: int) -> tuple[str, ...]:
        """Names of the channels beyond their range in a stretch: by the samples, or by the device's flag."""
        flags = self._conversion.overloaded_channels(self.view_samples(first, count))
        for begin, end, flag in self._overloads:
            if begin < first + count and end > first:
                flags = flags | flag
        return tuple(name for name, over in zip(self._conversion.names, flags, strict=True) if over)

    def _remember(self, chunk: SampleChunk) -> None:
        count = chunk.samples.shape[1]
        if self._filled + count > self._buffer.shape[1]:
            kept = self._buffer[:, self._filled - self._keep : self._filled].copy()
            self._buffer[:, : self._keep] = kept
            self._filled = self._keep
        self._buffer[:, self._filled : self._filled + count] = chunk.samples
        self._filled += count
        self.next += count
        if chunk.overload.any():
            self._overloads.append((chunk.first_sample, self.next, chunk.overload))
        while self._overloads and self._overloads[0][1] < self.next - self._buffer.shape[1]:
            self._overloads.popleft()
