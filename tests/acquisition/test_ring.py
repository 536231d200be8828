"""The ring that other processes read: what is taken from it is what was written, or is said to be gone."""

import multiprocessing
from pathlib import Path

import numpy as np
import pytest

from modallab.acquisition.monitor.ring_buffer import CELL, RingBuffer, RingBufferLayout, make_ring_buffer

SHAPE = RingBufferLayout(3, 8 * CELL, "<i4")


@pytest.fixture
def ring():
    made = make_ring_buffer(SHAPE)
    yield made
    made.path.unlink()
    made.close()


def count_up(first: int, count: int) -> np.ndarray:
    """Every sample says where it stands: a hole or a double one shows."""
    return (np.arange(first, first + count) * np.array([[1], [2], [3]])).astype(np.int32)


def write(ring: RingBuffer, count: int, over: tuple[bool, bool, bool] = (False, False, False)) -> None:
    ring.write(count_up(ring.samples_written, count), np.array(over))


def test_a_reader_takes_what_was_written_across_the_end_of_the_ring(ring: RingBuffer) -> None:
    reader = RingBuffer(ring.path, SHAPE)
    at = 0
    for count in (700, 900, 1000, 1, 2000, 1500):
        write(ring, count)
        first, samples, _ = reader.read(at, count)
        assert first == at
        np.testing.assert_array_equal(samples, count_up(at, count))
        at += count
    assert reader.read(at, 100)[1].shape == (3, 0)


def test_what_is_gone_is_not_given_but_counted(ring: RingBuffer) -> None:
    for _ in range(5):
        write(ring, 1000)
    first, samples, _ = RingBuffer(ring.path, SHAPE).read(0, 10_000)
    assert first == 5000 - SHAPE.capacity
    np.testing.assert_array_equal(samples, count_up(first, SHAPE.capacity))


def test_overload_is_of_its_stretch_and_forgotten_with_it(ring: RingBuffer) -> None:
    write(ring, 2 * CELL)
    write(ring, CELL, (False, True, False))
    write(ring, CELL)
    assert ring.read(0, 4 * CELL)[2].tolist() == [[False] * 4, [False, False, True, False], [False] * 4]
    for _ in range(8):
        write(ring, CELL)
    assert not ring.read(ring.oldest_sample, SHAPE.capacity)[2].any()


def _write_fast(path: Path, shape: RingBufferLayout, begin: "multiprocessing.synchronize.Event") -> None:
    ring = RingBuffer(path, shape, write=True)
    begin.wait()
    for _ in range(20_000):
        write(ring, 97)


def test_a_reader_beside_a_writer_that_overtakes_it_never_takes_torn_samples(ring: RingBuffer) -> None:
    spawn = multiprocessing.get_context("spawn")
    begin = spawn.Event()
    writer = spawn.Process(target=_write_fast, args=(ring.path, SHAPE, begin))
    writer.start()
    begin.set()
    reader, at, seen, lost = RingBuffer(ring.path, SHAPE), 0, 0, 0
    while writer.is_alive() or at < reader.samples_written:
        first, samples, _ = reader.read(at, SHAPE.capacity)
        np.testing.assert_array_equal(samples, count_up(first, samples.shape[1]))
        lost += first - at
        seen += samples.shape[1]
        at = first + samples.shape[1]
    writer.join()
    assert writer.exitcode == 0
    assert seen + lost == 20_000 * 97


@pytest.mark.parametrize(
    ("channels", "rate_hz", "seconds"), [(11, 2000.0, 10.0), (64, 51200.0, 10.0), (512, 1e6, 10.0)]
)
def test_a_ring_lasts_as_long_as_asked_or_as_memory_allows(channels: int, rate_hz: float, seconds: float) -> None:
    shape = RingBufferLayout.of_duration(channels, rate_hz, np.dtype(np.float32), seconds)
    assert shape.sample_bytes <= 2**28
    assert shape.capacity <= seconds * rate_hz
    assert shape.capacity > seconds * rate_hz - CELL or shape.sample_bytes > 0.9 * 2**28
