"""Data folders of older versions stay readable, and become new ones in one step or not at all."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from recording import begin, noise
from sqlalchemy import Connection, Engine, inspect, text

from modallab.core.errors import FormatError
from modallab.core.versions import STORE
from modallab.storage import BlockNote, Store, campaign_of
from modallab.storage.catalogue import STEPS, migrate_tables
from modallab.storage.engine import open_engine

OLD = Path(__file__).parents[1] / "data" / "store_v1"
TABLES = {"store", "runs", "blocks"}


@pytest.fixture
def old(tmp_path: Path) -> Path:
    return Path(shutil.copytree(OLD, tmp_path / "old"))


def test_a_folder_of_version_1_is_read_bit_for_bit(old: Path) -> None:
    """Written by the program of that time: two good runs, int16 and float32, and an aborted one."""
    with Store(old) as store:
        first, second, third = store.catalogue.runs()
        for run, dtype, seed in ((first, "int16", 1), (second, "float32", 2)):
            blocks = store.blocks(run.id)
            assert [block.name for block in blocks] == ["impact_p01_1", "impact_p01_3"]
            for block, k in zip(blocks, (0, 2), strict=True):
                np.testing.assert_array_equal(block.samples, noise(10 * seed + k, dtype))
            notes = [row.note for row in store.catalogue.blocks(run.id)]
            assert notes[1] == BlockNote(
                "impact_p01_2", "impact", 1000, 1, accepted=False, reason="too weak", facts={"peak_n": 51.5}
            )
        assert (third.state, third.valid) == ("aborted", False)
        assert len(campaign_of(store, [first.id, second.id]).blocks) == 4


def test_a_folder_of_version_1_becomes_one_of_today_and_goes_on(old: Path) -> None:
    with Store(old) as store:
        assert _version(store.catalogue.engine) == STORE
        run = store.catalogue.runs()[0].id
        store.drop_block(run, "impact_p01_1")
        with begin(store) as recorder:
            recorder.record_block(noise(9), BlockNote("new", "impact", 0))
            recorder.enter_state("done")
    with Store(old) as store:
        assert [block.name for block in store.blocks(run)] == ["impact_p01_3"]
        assert len(store.catalogue.runs()) == 4


def test_facts_of_older_programs_are_read_under_todays_names(old: Path) -> None:
    former = {"at_rest_before": "yes", "rest_level": 0.5, "rest_excess": 1.5, "rest_line_hz": 4.5, "peak_n": 51.5}
    with Store(old) as store, begin(store) as recorder:
        renamed = "impact_p01_1_refused_1"
        recorder.record_block(noise(9), BlockNote(renamed, "impact", 0, accepted=False, facts=former))
        recorder.enter_state("done")
        (row,) = store.catalogue.blocks(recorder.run)
    assert row.note.facts == {
        "settled_before": "yes", "motion_level": 0.5, "motion_excess": 1.5, "motion_line_hz": 4.5, "peak_n": 51.5,
    }  # fmt: skip
    assert row.note.name == renamed


def test_a_step_that_fails_leaves_the_folder_as_it_was(old: Path) -> None:
    def half(connection: Connection) -> None:
        connection.execute(text("CREATE TABLE half (x INTEGER)"))
        connection.execute(text("UPDATE runs SET state = 'lost'"))
        raise RuntimeError("the power went")

    engine = open_engine(f"sqlite:///{(old / 'modallab.db').as_posix()}")
    with pytest.raises(RuntimeError), engine.begin() as connection:
        migrate_tables(connection, "here", {2: half})
    assert set(inspect(engine).get_table_names()) == TABLES
    assert _version(engine) == 1
    engine.dispose()
    with Store(old) as store:
        assert [run.state for run in store.catalogue.runs()] == ["done", "done", "aborted"]


def test_steps_are_taken_in_order_from_where_the_folder_stands(old: Path) -> None:
    taken: list[int] = []
    steps = {n: lambda _, n=n: taken.append(n) for n in (2, 3, 4)}
    engine = open_engine(f"sqlite:///{(old / 'modallab.db').as_posix()}")
    with engine.begin() as connection:
        migrate_tables(connection, "here", steps, 3)
    with engine.begin() as connection:
        migrate_tables(connection, "here", steps, 4)
    assert taken == [2, 3, 4]
    assert _version(engine) == 4
    engine.dispose()


def test_every_version_has_its_step() -> None:
    assert sorted(STEPS) == list(range(2, STORE + 1))


@pytest.mark.parametrize("version", [0, STORE + 1, 1000])
def test_a_folder_of_an_unknown_version_is_rejected_and_untouched(old: Path, version: int) -> None:
    engine = open_engine(f"sqlite:///{(old / 'modallab.db').as_posix()}")
    with engine.begin() as connection:
        connection.execute(text(f"UPDATE store SET format_version = {version}"))
    with pytest.raises(FormatError, match=f"has format version {version}, this program knows up to {STORE}"):
        Store(old)
    assert set(inspect(engine).get_table_names()) == TABLES
    engine.dispose()


def _version(engine: Engine) -> int:
    with engine.connect() as connection:
        return int(connection.execute(text("SELECT format_version FROM store")).scalar_one())
