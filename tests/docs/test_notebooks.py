"""The notebooks show what their files say; the one on the gap is run where its campaign is, with the commands."""

import os
import sys
from pathlib import Path

import pytest
from notebooks import FOLDER, notebook_differences

SERVED = pytest.param("rest-client", marks=pytest.mark.thorough("starts a service"))


@pytest.mark.parametrize("name", ["first-test", "own-frfs", SERVED])
def test_a_notebook_shows_what_it_says(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    assert not notebook_differences(FOLDER / f"{name}.ipynb", tmp_path)
