"""A store to record into, and the rig of the demonstration."""

from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest

from modallab.core.rig import Rig
from modallab.formats.rig.rig_file import read_rig
from modallab.storage import Store


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with Store(tmp_path / "data") as opened:
        yield opened


@pytest.fixture(scope="session")
def link_rig() -> Rig:
    return read_rig(Path(str(resources.files("modallab.cli") / "link_rig.yaml")))
