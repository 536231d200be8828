"""One thread of linear algebra a process, unless the user says otherwise."""

import os
from pathlib import Path

import pytest

from modallab.cli import main

NAMES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")


def test_a_command_uses_one_thread_of_linear_algebra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in NAMES:
        # Set first, so that what the command sets is taken back in the end.
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    assert main(["identify", str(tmp_path / "nothing")]) == 2
    assert [os.environ[name] for name in NAMES] == ["1", "1"]


def test_what_the_user_says_of_threads_holds(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in NAMES:
        monkeypatch.setenv(name, "2")
    assert main(["identify", str(tmp_path / "nothing")]) == 2
    assert [os.environ[name] for name in NAMES] == ["2", "2"]
