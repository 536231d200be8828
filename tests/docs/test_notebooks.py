"""The notebooks show what their files say; the one on the gap is run where its campaign is, with the commands."""

import os
import shutil
import sys
from pathlib import Path

import pytest
from notebooks import FOLDER, notebook_differences
from pages import ROOT

IN_USE = pytest.param("model-in-use", marks=pytest.mark.thorough("identifies 18 modes of real hits, 8 s"))
SERVED = pytest.param("rest-client", marks=pytest.mark.thorough("starts a service"))


@pytest.mark.parametrize("name", ["first-test", "own-frfs", IN_USE, SERVED])
def test_a_notebook_shows_what_it_says(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    shutil.copy(ROOT / "tests/data/hammer_5hits.h5", tmp_path)
    assert not notebook_differences(FOLDER / f"{name}.ipynb", tmp_path)
