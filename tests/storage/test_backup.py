"""A backup is whole, of one moment, and can be gone on with; retention deletes what was asked for and remembers it."""

import shutil
import threading
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path

import h5py
import numpy as np
import pytest
from postgresql_server import Server
from recording import begin, noise
from sqlalchemy import select, text

from modallab.core.errors import DiskFullError, StorageError
from modallab.jobs import Jobs
from modallab.jobs.leases import JobLeases
from modallab.jobs.table import METADATA as JOBS_METADATA
from modallab.storage import BlockNote, Recorder, Store
from modallab.storage.backup import back_up, restore_backup
from modallab.storage.campaigns import RetentionRule, find_removable, remove_samples
from modallab.storage.tables import BLOCKS, RUNS


def _record(store: Store, seed: int, state: str = "done", valid: bool = True) -> str:
    with begin(store) as recorder:
        for k in range(3):
            recorder.record_block(noise(seed + k), BlockNote(f"b{k}", "impact", 64 * k))
        recorder.enter_state(state, valid=valid)
    return recorder.run


def test_a_backup_is_a_data_folder_with_the_same_rows_and_samples(any_store: Store, tmp_path: Path) -> None:
    runs = [_record(any_store, 10), _record(any_store, 20)]
    jobs = Jobs(any_store.catalogue.engine)
    job = jobs.submit("identify", {"a": 1}, [runs[0]])
    leases = JobLeases(any_store.catalogue.engine, "one")
    leases.complete(leases.lease_jobs(["identify"], 1)[0], {"modes": [1.5, None]})
    (any_store.folder / "results" / job.id).mkdir(parents=True)
    (any_store.folder / "results" / job.id / "report.html").write_text("a report")

    copied = back_up(any_store, tmp_path / "backup", [JOBS_METADATA])
    assert (copied.runs, copied.blocks) == (2, 6)
    with Store(tmp_path / "backup") as backup:
        for table in (RUNS, BLOCKS):
            with any_store.catalogue.engine.connect() as a, backup.catalogue.engine.connect() as b:
                assert (
                    a.execute(select(table).order_by(*table.primary_key)).all()
                    == b.execute(select(table).order_by(*table.primary_key)).all()
                )
        for run, seed in zip(runs, (10, 20), strict=True):
            for k, block in enumerate(backup.blocks(run)):
                np.testing.assert_array_equal(block.samples, noise(seed + k))
        assert Jobs(backup.catalogue.engine).get(job.id).result == {"modes": [1.5, None]}
        assert (backup.folder / "results" / job.id / "report.html").read_text() == "a report"


@pytest.mark.thorough("starts a PostgreSQL server")
def test_a_backup_is_restored_to_a_server_and_both_count_on(store: Store, tmp_path: Path, postgresql: Server) -> None:
    run = _record(store, 10)
    job = Jobs(store.catalogue.engine).submit("identify", {}, [run])
    back_up(store, tmp_path / "backup", [JOBS_METADATA])
    url = postgresql.new_database()
    restore_backup(tmp_path / "backup", tmp_path / "new", url, [JOBS_METADATA])
    with Store(tmp_path / "new") as new:
        assert new.catalogue.engine.dialect.name == "postgresql"
        assert [block.name for block in new.blocks(run)] == ["b0", "b1", "b2"]
        jobs = Jobs(new.catalogue.engine)
        assert jobs.get(job.id) == job
        # The server's counter stands behind the rows that came.
        assert [j.id for j in jobs.list().jobs] == [jobs.submit("report", {}, []).id, job.id][1:]
        assert len(jobs.list().jobs) == 2
        _record(new, 30)
    with pytest.raises(StorageError, match="has runs already"):
        restore_backup(tmp_path / "backup", tmp_path / "other", url, [JOBS_METADATA])


def test_a_backup_while_a_run_is_recorded_is_of_one_moment(any_store: Store, tmp_path: Path) -> None:
    """One thread records without a pause; each of three backups holds a whole beginning of the run."""
    stop, kept = threading.Event(), list[int]()
    recorder: Recorder = begin(any_store)
    recorder.enter_state("acquiring")

    def go_on() -> None:
        while not stop.is_set():
            recorder.record_block(noise(len(kept)), BlockNote(f"b{len(kept)}", "impact", 64 * len(kept)))
            kept.append(1)

    thread = threading.Thread(target=go_on)
    thread.start()
    try:
        while len(kept) < 2:
            assert thread.is_alive()
            time.sleep(0.001)
        counts = [_check_backup(any_store, recorder.run, tmp_path / str(n), kept) for n in range(3)]
    finally:
        stop.set()
        thread.join()
        recorder.close()
    assert counts == sorted(counts)
    assert len(kept) > counts[0]


def _check_backup(store: Store, run: str, out: Path, kept: list[int]) -> int:
    before = len(kept)
    back_up(store, out)
    # No SWMR, no marks of a writer: the copy is a closed file.
    with h5py.File(out / "runs" / f"{run}.h5") as file:
        assert file.attrs["run"] == run
    with Store(out) as backup:
        assert backup.catalogue.run(run).state == "acquiring"
        blocks = backup.blocks(run)
        for k, block in enumerate(blocks):
            np.testing.assert_array_equal(block.samples, noise(k))
        assert len(blocks) >= before
    with Store(restore_to(out)) as again:
        assert (again.catalogue.run(run).state, again.catalogue.run(run).reason) == ("failed", "interrupted")
        assert len(again.blocks(run)) == len(blocks)
    return len(blocks)


def restore_to(backup: Path) -> Path:
    out = backup.with_name(backup.name + "-restored")
    restore_backup(backup, out)
    return out


def test_damage_is_found_when_a_backup_is_made_not_when_it_is_needed(store: Store, tmp_path: Path) -> None:
    run = _record(store, 10)
    with h5py.File(store.folder / "runs" / f"{run}.h5", "r+") as file:
        file["samples"][0, 70] ^= 1
    with pytest.raises(StorageError, match="block b1 differs from the recording"):
        back_up(store, tmp_path / "backup")


def test_a_backup_is_never_written_over_anything(store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _record(store, 10)
    with pytest.raises(StorageError, match="not empty"):
        back_up(store, store.folder)
    with pytest.raises(StorageError, match="is no data folder"):
        restore_backup(tmp_path / "nothing", tmp_path / "out")
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=10))
    with pytest.raises(DiskFullError, match="are needed"):
        back_up(store, tmp_path / "backup")


def test_retention_takes_invalid_runs_only_unless_it_is_asked_to(store: Store) -> None:
    good, aborted, failed = (_record(store, 1), _record(store, 2, "aborted", valid=False), _record(store, 3, "failed"))
    with begin(store) as active:
        active.record_block(noise(1), BlockNote("b", "impact", 0))
        rules = {
            "default": RetentionRule(),
            "failed too": RetentionRule(also_valid=True),
            "all that ended": RetentionRule(states=("done", "failed", "aborted"), also_valid=True),
            "valid, not asked for": RetentionRule(states=("done",)),
            "old": RetentionRule(older_than=timedelta(days=1), states=("done", "aborted"), also_valid=True),
        }
        found = {name: {item.run.id for item in find_removable(store, rule)} for name, rule in rules.items()}
        with pytest.raises(StorageError, match="acquiring are active"):
            find_removable(store, RetentionRule(states=("acquiring",)))
    assert found == {
        "default": {aborted},
        "failed too": {aborted, failed},
        "all that ended": {good, aborted, failed},
        "valid, not asked for": set(),
        "old": set(),
    }
    later = datetime.now(UTC) + timedelta(days=2)
    assert {item.run.id for item in find_removable(store, rules["old"], later)} == {good, aborted}


def test_what_retention_deleted_is_remembered(any_store: Store, tmp_path: Path) -> None:
    good, aborted = _record(any_store, 1), _record(any_store, 2, "aborted", valid=False)
    found = find_removable(any_store, RetentionRule())
    freed = remove_samples(any_store, found, "older than 90 days")
    assert freed == found[0].size > 0
    assert find_removable(any_store, RetentionRule()) == ()
    assert len(any_store.blocks(good)) == 3
    assert len(any_store.catalogue.blocks(aborted)) == 3
    with pytest.raises(StorageError, match=r"were deleted .*older than 90 days"):
        any_store.blocks(aborted)
    back_up(any_store, tmp_path / "backup")
    with Store(tmp_path / "backup") as backup, backup.catalogue.engine.connect() as connection:
        assert connection.execute(text("SELECT run FROM removed")).scalars().all() == [aborted]
        assert len(backup.blocks(good)) == 3
