"""What is acknowledged is on the disk, and comes back bit for bit with all that belongs to it."""

import zlib

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recording import INFO, PLAN, begin, delivery, noise, small_rig
from sqlalchemy import delete, update
from sqlalchemy.exc import IntegrityError

from modallab import __version__
from modallab.core.errors import StorageError
from modallab.storage import BlockNote, Store, rig_hash
from modallab.storage.tables import BLOCKS


@pytest.mark.parametrize("dtype", ["int16", "int32", "float32", "float64"])
def test_a_block_comes_back_bit_for_bit_with_its_facts(store: Store, dtype: str) -> None:
    samples = noise(1, dtype)
    note = BlockNote("impact_p01_1", "impact", 12345, drive_point=1, overload=("a01",), facts={"peak_n": 61.5})
    with begin(store, dtype=dtype) as recorder:
        acknowledged = recorder.record_block(samples, note)
    (block,) = store.blocks(recorder.run)
    assert block.samples.dtype == np.dtype(dtype)
    assert block.samples.tobytes() == samples.tobytes()
    assert acknowledged.crc32 == zlib.crc32(samples.astype(samples.dtype.newbyteorder("<")).tobytes())
    assert (block.name, block.first_sample, block.drive_point) == ("impact_p01_1", 12345, 1)
    assert (block.requested_rate_hz, block.actual_rate_hz, block.rate_hz) == (1000.0, 1651.6, 2000.0)
    assert block.units == ("V", "V")
    np.testing.assert_array_equal(block.scale, [1e-4, 2e-4])
    (row,) = store.catalogue.blocks(recorder.run)
    assert row.note == note


def test_samples_that_are_placed_are_a_block_only_once_they_are_kept(store: Store) -> None:
    with begin(store) as recorder:
        recorder.place_block(noise(1))
        good = recorder.place_block(noise(2))
        assert recorder.keep_block(good, BlockNote("good", "impact", 64)).n == 0
        recorder.place_block(noise(3))
    (block,) = store.blocks(recorder.run)
    assert block.samples.tobytes() == noise(2).tobytes()


def test_a_run_keeps_all_that_is_needed_to_repeat_it(store: Store) -> None:
    with begin(store) as recorder:
        recorder.enter_state("done")
    run = store.catalogue.run(recorder.run)
    assert (run.plan, run.rig, run.rig_hash) == (PLAN, small_rig(), rig_hash(small_rig()))
    assert (run.bench_url, run.code_version) == (INFO.url, __version__)
    assert run.facts == {"seed": "7", "device 0": "box, serial 0042"}
    assert run.state == "done"
    assert run.ended_utc > run.created_utc


def test_the_file_explains_itself_without_the_catalogue(store: Store) -> None:
    with begin(store) as recorder:
        recorder.record_block(noise(1), BlockNote("b", "impact", 0))
    with h5py.File(store.folder / "runs" / f"{recorder.run}.h5") as file:
        assert file["samples"].shape == (2, 64)
        assert file.attrs["rig"] == small_rig().model_dump_json()
        assert list(file.attrs["channels"]) == ["force", "a01"]
        assert file.attrs["rate_hz"] == 2000.0


@given(counts=st.lists(st.integers(1, 200), min_size=1, max_size=8))
@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_blocks_of_any_length_stand_one_after_the_other(store: Store, counts: list[int]) -> None:
    blocks = [noise(n, count=count) for n, count in enumerate(counts)]
    with begin(store) as recorder:
        for n, samples in enumerate(blocks):
            recorder.record_block(samples, BlockNote(f"b{n}", "impact", 0))
    for kept, given_ in zip(store.blocks(recorder.run), blocks, strict=True):
        np.testing.assert_array_equal(kept.samples, given_)


def test_rejected_blocks_are_kept_and_left_out_unless_asked_for(store: Store) -> None:
    with begin(store) as recorder:
        recorder.record_block(noise(1), BlockNote("bad", "impact", 0, accepted=False, reason="too weak: 3 N"))
        recorder.record_block(noise(2), BlockNote("good", "impact", 64))
    assert [b.name for b in store.blocks(recorder.run)] == ["good"]
    assert [b.name for b in store.blocks(recorder.run, rejected=True)] == ["bad", "good"]
    assert store.catalogue.blocks(recorder.run)[0].note.reason == "too weak: 3 N"


def test_a_running_file_can_be_read_from_a_second_store(store: Store) -> None:
    with begin(store) as recorder, Store(store.folder) as other:
        for n in range(3):
            recorder.record_block(noise(n), BlockNote(f"b{n}", "impact", 64 * n))
            assert len(other.blocks(recorder.run)) == n + 1


def test_the_table_of_blocks_is_append_only(store: Store) -> None:
    with begin(store) as recorder:
        recorder.record_block(noise(1), BlockNote("b", "impact", 0))
    engine = store.catalogue.engine
    for change in (update(BLOCKS).values(crc32=0), delete(BLOCKS)):
        with pytest.raises(IntegrityError, match="append-only"), engine.begin() as connection:
            connection.execute(change)


def test_recording_before_the_delivery_is_known_is_rejected(store: Store) -> None:
    with store.begin(PLAN, small_rig(), INFO) as recorder, pytest.raises(StorageError, match="no file is open"):
        recorder.record_block(noise(1), BlockNote("b", "impact", 0))


def test_an_unknown_run_is_named(store: Store) -> None:
    with pytest.raises(StorageError, match="no run 'nowhere'"):
        store.blocks("nowhere")


def test_an_existing_file_is_never_written_over(store: Store) -> None:
    recorder = store.begin(PLAN, small_rig(), INFO)
    path = store.folder / "runs" / f"{recorder.run}.h5"
    path.write_bytes(b"someone's data")
    with recorder, pytest.raises(StorageError):
        recorder.open(delivery(), 64)
    assert path.read_bytes() == b"someone's data"
