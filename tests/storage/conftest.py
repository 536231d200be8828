"""A store to record into, with its catalogue in SQLite and on a PostgreSQL server."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from postgresql_server import DATABASES, Server

from modallab.storage import Store
from modallab.storage.engine import name_database


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "data") as opened:
        yield opened


@pytest.fixture
def pg_store(tmp_path: Path, postgresql: Server) -> Iterator[Store]:
    name_database(tmp_path / "pg", postgresql.new_database())
    with Store(tmp_path / "pg") as opened:
        yield opened


@pytest.fixture(params=DATABASES)
def any_store(request: pytest.FixtureRequest) -> Store:
    return request.getfixturevalue("store" if request.param == "sqlite" else "pg_store")
