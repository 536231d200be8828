"""One thread of linear algebra a process, unless the user says otherwise."""

import os
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info

from modallab.cli import main
from modallab.core.blas_threads import one_thread

NAMES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")


def thread_counts() -> list[int]:
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


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


def test_in_a_script_threads_are_one_while_a_model_is_computed_and_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    before = thread_counts()
    assert before, "NumPy's OpenBLAS is not found where its wheel has it"
    with one_thread():
        with one_thread():
            assert set(thread_counts()) == {1}
        assert set(thread_counts()) == {1}
    assert thread_counts() == before


def test_in_a_script_too_what_the_user_says_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(NAMES[0], "3")
    before = thread_counts()
    with one_thread():
        assert thread_counts() == before
