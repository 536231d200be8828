"""README and pages do what they say: their blocks are run in one folder, in a reader's order.

`console` blocks are run line by line and compared with what the page prints below each `$`; `python` blocks are run as
scripts and compared with the `text` block after them, where there is one. `make` stands for its recipe.
"""

import io
import re
import runpy
import shlex
import shutil
from contextlib import chdir, redirect_stderr, redirect_stdout
from functools import cache
from itertools import chain, pairwise
from pathlib import Path

import pytest
from notebooks import notebook_differences
from pages import ROOT, Fenced, fenced, name
from transcript import difference

from modallab.cli import main

WALK = (
    ROOT / "README.md",
    ROOT / "docs/tutorial/first-test.md",
    *sorted((ROOT / "docs/how-to").glob("*.md")),
    *sorted((ROOT / "docs/explanation").glob("*.md")),
    *sorted((ROOT / "docs/reference").glob("*.md")),
)
ELSEWHERE = {"docs/how-to/first-connection.md"}
"""Pages whose commands need a device, or are run by tests of their own."""


def test_every_command_prints_what_its_page_says(tmp_path: Path, demo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    wrong: list[str] = []
    # The demo is run once for all tests.
    shutil.copytree(demo, tmp_path / "demo")
    printed = {"modallab demo --out demo": (demo.parent / "printed.txt").read_text(encoding="utf-8").splitlines()}
    for page in WALK:
        if name(page) not in ELSEWHERE:
            wrong += _walk(fenced(page), tmp_path, printed)
    # It opens what the README has recorded and diagnosed.
    wrong += notebook_differences(ROOT / "docs/notebooks/gap.ipynb", tmp_path)
    assert not wrong, "\n\n".join(wrong)


def _walk(blocks: list[Fenced], folder: Path, printed: dict[str, list[str]]) -> list[str]:
    wrong: list[str] = []
    for block, after in pairwise(chain(blocks, [None])):
        assert block is not None
        if block.language == "console":
            for command, said in _commands(block):
                key = _recipe(command)
                if key is not None:
                    # Who reads on has already run it.
                    printed[key] = printed.get(key) or _run(shlex.split(key), folder)
                    wrong += _reported(block, command, difference(said, printed[key]))
        elif block.language == "python":
            said = list(after.lines) if after is not None and after.language == "text" else None
            script = folder / "page_script.py"
            script.write_text("\n".join(block.lines) + "\n", encoding="utf-8")
            lines = _run(["python", script.name], folder)
            wrong += _reported(block, "python", difference(["..."] if said is None else said, lines))
    return wrong


def _reported(block: Fenced, command: str, what: str) -> list[str]:
    return [f"{block.place}: {command}: {what}"] if what else []


def _commands(block: Fenced) -> list[tuple[str, list[str]]]:
    found: list[tuple[str, list[str]]] = []
    for line in block.lines:
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            assert found, f"{block.place}: begins without a command"
            found[-1][1].append(line)
    return found


def _recipe(command: str) -> str | None:
    """What is run for a command: itself, or the recipe of a make target. Not the tests within the tests."""
    if not command.startswith("make "):
        return command
    recipes = _recipes()
    target = command.removeprefix("make ")
    assert target in recipes, f"the Makefile has no target {target}"
    return None if target == "test" else " && ".join(recipes[target])


@cache
def _recipes() -> dict[str, list[str]]:
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    found = re.findall(r"^(\w+):.*\n((?:\t.*\n)*)", text, re.MULTILINE)
    return {target: [line.replace("$(BIN)/", "").strip() for line in body.splitlines()] for target, body in found}


def _run(command: list[str], folder: Path) -> list[str]:
    """Run in this process: that the command itself starts is shown where the wheel is tested."""
    words = [word for part in command[1:] for word in _matches(part, folder)]
    said = io.StringIO()
    with chdir(folder), redirect_stdout(said), redirect_stderr(said):
        if command[0] == "modallab":
            main(words)
        else:
            assert command[0] == "python"
            # A process it spawns looks for the script by this path, from another folder.
            runpy.run_path(str(folder / words[0]), run_name="__main__")
    return said.getvalue().splitlines()


def _matches(part: str, folder: Path) -> list[str]:
    if "*" not in part:
        return [part]
    return sorted(found.relative_to(folder).as_posix() for found in folder.glob(part))
