"""A store to record into."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from modallab.storage import Store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "data") as opened:
        yield opened
