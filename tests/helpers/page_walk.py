"""Runs the blocks of a page in one folder, as its reader would, and says where the page is wrong.

`console` blocks are run line by line and compared with what the page prints below each `$`; `python` blocks are run as
scripts and compared with the `text` block after them, where there is one. Each line of an `sh` block must succeed; a
`py` block is run with the names that its reader has by then. `make` stands for its recipe.
"""

import io
import re
import runpy
import shlex
import signal
from collections.abc import Callable, Mapping, MutableMapping
from contextlib import chdir, redirect_stderr, redirect_stdout
from functools import cache
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

from pages import ROOT, Fenced, needs_service
from transcript import difference

from modallab.cli import main


class Walk:
    """One reader's folder.

    Args:
        folder: where the commands are run.
        printed: what commands have printed that were run before.
        names: what the reader's own variables hold, in `py` blocks.
        words: what stands on the reader's machine for words of the page, or who finds it out when it is needed.
        ran: lines that were run before; they are not run again.
    """

    def __init__(
        self,
        folder: Path,
        printed: MutableMapping[str, list[str]],
        names: Mapping[str, Any] | None = None,
        words: Mapping[str, str | Callable[[], str]] | None = None,
        ran: frozenset[str] = frozenset(),
    ) -> None:
        self._folder, self._printed, self._ran = folder, printed, ran
        self._names = dict(names or {})
        self._words = dict(words or {})

    def wrong(self, blocks: list[Fenced]) -> list[str]:
        """A text for each block that does not do what its page says."""
        found: list[str] = []
        for block, after in pairwise(chain(blocks, [None])):
            assert block is not None
            if block.not_run or needs_service(block):
                continue
            if block.language == "console":
                found += self._console(block)
            elif block.language in {"sh", "bash"}:
                found += self._shell(block)
            elif block.language == "python":
                said = list(after.lines) if after is not None and after.language == "text" else None
                found += self._script(block, said)
            elif block.language == "py":
                with chdir(self._folder):
                    exec(compile("\n".join(block.lines), block.place, "exec"), self._names)
        return found

    def _console(self, block: Fenced) -> list[str]:
        wrong: list[str] = []
        for command, said in _commands(block):
            key = " && ".join(_recipe(command))
            if key not in self._printed:
                self._printed[key] = self._run(shlex.split(key))[1]
            wrong += _reported(block, command, difference(said, self._printed[key]))
        return wrong

    def _shell(self, block: Fenced) -> list[str]:
        wrong: list[str] = []
        for line in "\n".join(block.lines).replace("\\\n", " ").splitlines():
            if line in self._ran or line in self._printed:
                continue
            for word, mine in self._words.items():
                if word in line:
                    line = line.replace(word, mine if isinstance(mine, str) else mine())
            code, printed = self._run(shlex.split(line, comments=True))
            self._printed[line] = printed
            wrong += _reported(block, line, f"exit code {code}: {printed[-8:]}" if code else "")
        return wrong

    def _script(self, block: Fenced, said: list[str] | None) -> list[str]:
        script = self._folder / "page_script.py"
        script.write_text("\n".join(block.lines) + "\n", encoding="utf-8")
        _, lines = self._run(["python", script.name])
        return _reported(block, "python", difference(["..."] if said is None else said, lines))

    def _run(self, command: list[str]) -> tuple[int, list[str]]:
        """Run in this process: that the command itself starts is shown where the wheel is tested."""
        words = [word for part in command[1:] for word in _matches(part, self._folder)]
        said = io.StringIO()
        code = 0
        with chdir(self._folder), redirect_stdout(said), redirect_stderr(said):
            if command[0] == "modallab":
                # `campaign run` takes SIGTERM over, as the only command of its process.
                before = signal.getsignal(signal.SIGTERM)
                code = main(words)
                signal.signal(signal.SIGTERM, before)
            else:
                assert command[0] == "python", command
                # A process it spawns looks for the script by this path, from another folder.
                runpy.run_path(str(self._folder / words[0]), run_name="__main__")
        return code, said.getvalue().splitlines()


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


def _recipe(command: str) -> list[str]:
    """What is run for a command: itself, or the recipe of a make target."""
    if not command.startswith("make "):
        return [command]
    recipes = _recipes()
    target = command.removeprefix("make ")
    assert target in recipes, f"the Makefile has no target {target}"
    return recipes[target]


@cache
def _recipes() -> dict[str, list[str]]:
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    found = re.findall(r"^(\w+):.*\n((?:\t.*\n)*)", text, re.MULTILINE)
    return {target: [line.replace("$(BIN)/", "").strip() for line in body.splitlines()] for target, body in found}


def _matches(part: str, folder: Path) -> list[str]:
    if "*" not in part:
        return [part]
    return sorted(found.relative_to(folder).as_posix() for found in folder.glob(part))
