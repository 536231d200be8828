"""A lock is held by one however it is given back; a new database is its owner's; a damaged row is named as such."""

import stat
import threading
import time
from pathlib import Path

import pytest
from recording import begin
from sqlalchemy import text

from modallab.core.child_process import FileLock
from modallab.core.errors import RowDamagedError, StorageError
from modallab.storage import Store


def test_one_holds_the_lock_while_others_take_it_and_give_it_back(tmp_path: Path) -> None:
    held, twice, path = threading.Lock(), list[int](), tmp_path / "lock"

    def hold() -> None:
        for n in range(300):
            lease = FileLock(path)
            if not lease.acquire():
                continue
            if not held.acquire(blocking=False):
                twice.append(n)
            else:
                time.sleep(0.0002)
                held.release()
            lease.release()

    threads = [threading.Thread(target=hold) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert twice == []
    assert not path.exists()


def test_a_new_database_is_for_its_owner_only(store: Store) -> None:
    with begin(store):
        files = list(store.folder.glob("modallab.db*"))
        assert files
        assert all(stat.S_IMODE(file.stat().st_mode) == 0o600 for file in files)


@pytest.mark.parametrize("damage", ["CAST(x'ff' AS TEXT)", "'{'"], ids=["bytes", "JSON"])
def test_a_damaged_row_is_an_error_of_our_own_without_sql(store: Store, damage: str) -> None:
    with begin(store) as recorder:
        recorder.enter_state("done")
    with store.catalogue.engine.begin() as connection:
        connection.execute(text(f"UPDATE runs SET facts = {damage}"))
    for look in (store.catalogue.runs, lambda: store.catalogue.run(recorder.run)):
        with pytest.raises(StorageError) as found:
            look()
        assert isinstance(found.value, RowDamagedError) or "damaged" in found.value.what
        assert "SELECT" not in str(found.value)
