"""The same catalogue in SQLite and on a real PostgreSQL server."""

import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from postgresql_server import Server
from recording import PLAN, begin, noise, small_rig
from sqlalchemy import delete, text, update
from sqlalchemy.exc import IntegrityError

from modallab.core.errors import DiskFullError, FormatError, StorageError
from modallab.storage import BlockNote, Store, campaign_of
from modallab.storage.engine import name_database, open_engine
from modallab.storage.tables import BLOCKS

NOTE = BlockNote("b", "impact", 2**40, drive_point=1, overload=("a01",), facts={"peak_n": 61.5})


def test_a_run_comes_back_with_all_that_belongs_to_it(any_store: Store) -> None:
    with begin(any_store, dtype="int32") as recorder:
        recorder.record_block(noise(1, "int32"), NOTE)
        recorder.record_block(noise(2, "int32"), BlockNote("rejected", "impact", 3, accepted=False, reason="too weak"))
        recorder.enter_state("done")
    run = any_store.catalogue.run(recorder.run)
    assert (run.state, run.rig, run.scale) == ("done", small_rig(), (1e-4, 2e-4))
    (block,) = any_store.blocks(recorder.run)
    np.testing.assert_array_equal(block.samples, noise(1, "int32"))
    assert any_store.catalogue.blocks(recorder.run)[0].note == NOTE
    any_store.drop_block(recorder.run, "b")
    assert any_store.blocks(recorder.run) == ()


def test_rows_of_blocks_are_never_changed_nor_deleted(any_store: Store) -> None:
    with begin(any_store) as recorder:
        recorder.record_block(noise(1), NOTE)
    for change in (update(BLOCKS).values(crc32=0), delete(BLOCKS)):
        with (
            pytest.raises(IntegrityError, match="blocks are append-only"),
            any_store.catalogue.engine.begin() as connection,
        ):
            connection.execute(change)


@pytest.mark.thorough("starts a PostgreSQL server")
def test_many_who_open_a_new_server_database_at_once_all_find_its_tables(tmp_path: Path, postgresql: Server) -> None:
    url, opened, barrier = postgresql.new_database(), list[int](), threading.Barrier(6, timeout=60)

    def open_it(n: int) -> None:
        folder = tmp_path / str(n)
        name_database(folder, url)
        barrier.wait()
        with Store(folder) as store:
            opened.append(len(store.catalogue.runs()))

    threads = [threading.Thread(target=open_it, args=(n,)) for n in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert opened == [0] * 6


@pytest.mark.thorough("starts a PostgreSQL server")
def test_a_server_that_restarts_between_two_blocks_is_found_again(pg_store: Store) -> None:
    with begin(pg_store) as recorder:
        recorder.record_block(noise(1), BlockNote("b1", "impact", 0))
        with pg_store.catalogue.engine.connect() as connection:
            connection.execute(
                text("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid()")
            )
        recorder.record_block(noise(2), BlockNote("b2", "impact", 64))
    assert [block.name for block in campaign_of(pg_store, [recorder.run]).blocks] == ["b1", "b2"]


def test_the_address_is_kept_for_its_owner_and_its_password_out_of_messages(tmp_path: Path) -> None:
    name_database(tmp_path, "postgresql://lab:secret@127.0.0.1:1/none")
    assert (tmp_path / "database.url").stat().st_mode & 0o077 == 0
    with pytest.raises(StorageError) as caught:
        Store(tmp_path)
    assert "127.0.0.1" in str(caught.value)
    assert "secret" not in str(caught.value)


def test_a_folder_has_one_catalogue_only(store: Store) -> None:
    with pytest.raises(FormatError, match=r"holds both modallab\.db and database\.url"):
        name_database(store.folder, "postgresql://lab@127.0.0.1:1/none")
    with Store(store.folder) as again:
        assert again.catalogue.runs() == ()


@pytest.mark.parametrize("url", ["mysql://lab@127.0.0.1/x", "no address", "postgresql://lab@127.0.0.1:port/x"])
def test_an_address_that_is_none_is_rejected(url: str) -> None:
    with pytest.raises(StorageError):
        open_engine(url)


def test_a_run_that_cannot_end_does_not_begin(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    # Hits of 64 samples of two channels of int16 need 256 bytes each, and a quarter more of all of them.
    plan, usage = PLAN.model_copy(update={"hits": 100_000}), shutil.disk_usage(store.folder)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=31_900_000))
    with pytest.raises(DiskFullError, match=r"31\.9 MB are free, 32\.0 MB are needed"):
        begin(store, plan=plan)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=32_100_000))
    begin(store, plan=plan).close()
