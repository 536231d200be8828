"""Damage is reported with its place; a crash, a full disk or a lost writer costs nothing that was acknowledged."""

import os
import shutil
from pathlib import Path
from typing import Any

import h5py
import pytest
from recording import INFO, PLAN, begin, noise, small_rig

from modallab.core.child_process import FileLock
from modallab.core.errors import DiskFullError, FormatError, StorageError
from modallab.storage import BlockNote, Store
from modallab.storage.catalogue import RunCatalogue
from modallab.storage.durable import file_system, require_local, require_space
from modallab.storage.samples import lookup3_checksum, seal_file


def recorded(store: Store, count: int = 3) -> tuple[str, Path]:
    with begin(store) as recorder:
        for n in range(count):
            recorder.record_block(noise(n), BlockNote(f"b{n}", "impact", 64 * n))
    return recorder.run, store.folder / "runs" / f"{recorder.run}.h5"


def test_a_flipped_byte_is_reported_with_run_and_block(store: Store) -> None:
    run, path = recorded(store)
    content = bytearray(path.read_bytes())
    place = content.index(noise(1).tobytes()) + 17
    content[place] ^= 0x04
    path.write_bytes(content)
    with pytest.raises(StorageError, match="samples on the disk differ from the recording") as caught:
        store.blocks(run)
    assert caught.value.where == f"run {run}, block 1, b1"
    assert next(iter(store.iterate_blocks(run))).name == "b0"


def test_a_file_cut_off_or_gone_is_reported_by_name(store: Store) -> None:
    run, path = recorded(store)
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(StorageError, match="cannot be read") as caught:
        store.blocks(run)
    assert caught.value.where == str(path)
    path.unlink()
    with pytest.raises(StorageError, match="cannot be read"):
        store.blocks(run)


def test_a_run_whose_recorder_died_is_marked_and_its_blocks_are_readable(store: Store) -> None:
    recorder = begin(store)
    recorder.enter_state("acquiring")
    recorder.record_block(noise(1), BlockNote("b", "impact", 0))
    # As a kill leaves it: the file copied while it is open for writing, the lease let go by the system.
    with Store(store.folder) as after:
        assert after.recover() == ()
        shutil.copy(store.folder / "runs" / f"{recorder.run}.h5", store.folder / "copy.h5")
        recorder.close()
        shutil.move(store.folder / "copy.h5", store.folder / "runs" / f"{recorder.run}.h5")
        assert after.recover() == (recorder.run,)
        run = after.catalogue.run(recorder.run)
        assert (run.state, run.reason) == ("failed", "interrupted")
        assert [b.name for b in after.blocks(recorder.run)] == ["b"]
        assert after.recover() == ()


def full_disk(*_: object) -> None:
    raise OSError(28, "No space left on device")


def test_a_disk_that_fills_up_costs_only_the_block_that_was_not_acknowledged(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with begin(store) as recorder:
        recorder.record_block(noise(0), BlockNote("b0", "impact", 0))
        with monkeypatch.context() as patch:
            patch.setattr(os, "fdatasync", full_disk, raising=False)
            patch.setattr(os, "fsync", full_disk)
            with pytest.raises(DiskFullError):
                recorder.record_block(noise(1), BlockNote("b1", "impact", 64))
        with pytest.raises(StorageError, match="earlier write failed"):
            recorder.record_block(noise(2), BlockNote("b2", "impact", 128))
        recorder.enter_state("failed", "disk full")
    assert [b.name for b in store.blocks(recorder.run)] == ["b0"]


def test_hdf5s_own_word_for_a_full_disk_is_understood(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def hdf5_says(_: h5py.Dataset) -> None:
        raise RuntimeError("Unable to flush dataset (file write failed: errno = 28, error message = 'No space left')")

    with begin(store) as recorder:
        recorder.record_block(noise(0), BlockNote("b0", "impact", 0))
        with monkeypatch.context() as patch:
            patch.setattr(h5py.Dataset, "flush", hdf5_says)
            with pytest.raises(DiskFullError) as caught:
                recorder.record_block(noise(1), BlockNote("b1", "impact", 64))
        assert "errno" not in str(caught.value)
        assert recorder.left_unusable_file
    assert [b.name for b in store.blocks(recorder.run)] == ["b0"]


def test_the_reserve_is_there_while_recording_and_gone_after(store: Store) -> None:
    with begin(store) as recorder:
        reserve = store.folder / "runs" / f"{recorder.run}.reserve"
        assert reserve.stat().st_size >= 1 << 20
    assert not reserve.exists()
    assert [p.suffix for p in (store.folder / "runs").iterdir()] == [".h5"]


def test_the_end_of_a_run_is_written_in_the_room_that_was_kept_for_it(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    with begin(store) as recorder:
        reserve = store.folder / "runs" / f"{recorder.run}.reserve"
        write = RunCatalogue.update_run

        def full_but_for_the_reserve(catalogue: RunCatalogue, run: str, **values: Any) -> None:
            if reserve.exists():
                raise DiskFullError("the disk is full", remedy="free space")
            write(catalogue, run, **values)

        monkeypatch.setattr(RunCatalogue, "update_run", full_but_for_the_reserve)
        recorder.enter_state("failed", "the disk is full")
    ended = store.catalogue.run(recorder.run)
    assert (ended.state, ended.reason) == ("failed", "the disk is full")


def test_too_little_room_is_rejected_with_both_numbers(tmp_path: Path) -> None:
    with pytest.raises(DiskFullError, match=r"MB are free, 1000000000000\.0 MB are needed"):
        require_space(tmp_path, 10**18)


MOUNTS = """\
22 1 254:1 / / rw,relatime shared:1 - ext4 /dev/vda rw
40 22 0:35 / /home/lab\\040data rw - nfs4 server:/export rw
41 40 0:36 / /home/lab\\040data/local rw - xfs /dev/sdb1 rw
"""


@pytest.mark.parametrize(
    ("folder", "kind"),
    [("/home/lab data/runs", "nfs4"), ("/home/lab data/local/x", "xfs"), ("/home/lab", "ext4"), ("/", "ext4")],
)
def test_the_file_system_of_a_folder_is_that_of_its_longest_mount(folder: str, kind: str) -> None:
    assert file_system(Path(folder), MOUNTS) == kind


def test_a_local_folder_is_allowed(tmp_path: Path) -> None:
    require_local(tmp_path)


def test_a_lease_has_one_holder_until_it_lets_go(tmp_path: Path) -> None:
    first, second = FileLock(tmp_path / "lease"), FileLock(tmp_path / "lease")
    assert first.acquire()
    assert not second.acquire()
    first.release()
    assert second.acquire()
    second.release()
    assert not (tmp_path / "lease").exists()


def test_a_folder_of_a_newer_version_is_rejected(store: Store) -> None:
    with store.catalogue.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE store SET format_version = 99")
    with pytest.raises(FormatError, match="format version 99"):
        Store(store.folder)


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(StorageError, match="cannot be made"):
        Store(tmp_path / "file" / "data")


def test_a_database_that_is_none_is_reported(tmp_path: Path) -> None:
    (tmp_path / "modallab.db").write_bytes(b"not a database, but long enough to look at" * 100)
    with pytest.raises(StorageError, match="is no database"):
        Store(tmp_path)


def test_a_new_run_is_created_and_leased(store: Store) -> None:
    with store.begin(PLAN, small_rig(), INFO) as recorder:
        assert store.catalogue.run(recorder.run).state == "created"
        assert store.recover() == ()
    assert store.recover() == (recorder.run,)


def left_by_a_kill(store: Store) -> tuple[str, Path]:
    recorder = begin(store)
    for n in range(3):
        recorder.record_block(noise(n), BlockNote(f"b{n}", "impact", 64 * n))
    path = store.folder / "runs" / f"{recorder.run}.h5"
    as_killed = path.read_bytes()
    recorder.close()
    path.write_bytes(as_killed)
    return recorder.run, path


def test_recovery_seals_the_file_so_that_it_opens_as_any_other(store: Store) -> None:
    run, path = left_by_a_kill(store)
    with pytest.raises(OSError, match="already open"):
        h5py.File(path)
    assert len(store.blocks(run)) == 3
    before = path.read_bytes()
    store.recover()
    assert path.read_bytes()[48:] == before[48:]
    with h5py.File(path) as file:
        assert file["samples"].shape == (2, 3 * 64)
    assert len(store.blocks(run)) == 3


@pytest.mark.parametrize("kept", [0.3, 0.9, 0.999])
def test_a_killed_runs_file_that_is_also_cut_off_is_reported(store: Store, kept: float) -> None:
    run, path = left_by_a_kill(store)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])
    store.recover()
    with pytest.raises(StorageError, match=r"cannot be read|differ from the recording|not in the file"):
        store.blocks(run)


def test_the_checksum_of_hdf5_is_jenkins_own() -> None:
    # The value its author published.
    assert lookup3_checksum(b"Four score and seven years ago") == 0x17770551


def test_what_is_no_killed_hdf5_file_is_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "other.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n\x03" + bytes(100))
    before = path.read_bytes()
    assert not seal_file(path)
    assert path.read_bytes() == before
