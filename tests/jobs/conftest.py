"""A table of jobs in a new database."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from postgresql_server import DATABASES
from sqlalchemy import Engine

from modallab.jobs import Jobs
from modallab.storage.engine import open_engine


@pytest.fixture
def engine(tmp_path: Path) -> Iterator[Engine]:
    opened = open_engine(f"sqlite:///{(tmp_path / 'jobs.db').as_posix()}")
    yield opened
    opened.dispose()


@pytest.fixture(params=DATABASES)
def each_engine(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Engine]:
    """A new database of each kind in turn."""
    url = f"sqlite:///{(tmp_path / 'jobs.db').as_posix()}"
    if request.param == "postgresql":
        url = request.getfixturevalue("postgresql").new_database()
    opened = open_engine(url)
    yield opened
    opened.dispose()


@pytest.fixture
def jobs(engine: Engine) -> Jobs:
    return Jobs(engine)
