"""Keeps retired words out of names, texts and comments: `RETIRED` is the rule, and the only place where it stands.

    python docs/reference/check_words.py
    python docs/reference/check_words.py --lower    writes what is left of what `check_pages.py` allows

A word counts wherever it stands by itself or as a part of a name, split at underscores and capitals: of a retired `old`
the names `old_count` and `lastOld` and the words "an old one" are found, "older" is not. Rules for names look only at
names of the code, of files and of JSON fields; a test's name is a sentence. Prints `file:line: word -> say instead` for
each and ends with 1 if there is any. What `check_pages.py` finds is printed and counted too.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path

import check_pages

ROOT = Path(__file__).parents[2]
LOOKED_AT = (
    "README.md",
    "Makefile",
    "pyproject.toml",
    "src",
    "drivers",
    "simulators",
    "tests",
    "benchmarks",
    "docs",
    "docker",
)
LEFT_OUT = ("tests/data/", "docs/images/", "docs/reference/check_words.py")
SUFFIXES = ("", ".py", ".md", ".toml", ".yaml", ".yml", ".json", ".html", ".css", ".js", ".sh", ".txt", ".sql")
OLD_SECTION = "## Changed words"
OLD_NAMES = "renamed"
"""Assignments to this name hold the names of earlier versions."""

_PART = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
_FIELD = re.compile(r'"(\w+)"\s*:')


@dataclass(frozen=True)
class Rule:
    """A word that is not used.

    Attributes:
        words: lower case; `*` at the end stands for any ending, `_` joins parts of one name.
        instead: what to say.
        names_only: whether sentences may hold it.
        allowed: phrases that hold it and are not ours.
    """

    words: tuple[str, ...]
    instead: str
    names_only: bool
    allowed: tuple[str, ...]

    @cached_property
    def hint(self) -> re.Pattern[str]:
        """What a text holds at least if it holds a word of this rule."""
        return re.compile("|".join(word.rstrip("*") for word in self.words), re.IGNORECASE)

    def found_in(self, text: str) -> Iterator[str]:
        """The words of this rule that `text` holds, as they are written there."""
        if not self.hint.search(text):
            return
        for phrase in self.allowed:
            text = re.sub(re.escape(phrase), " ", text, flags=re.IGNORECASE)
        for run in re.findall(r"\w+", text):
            parts = [part.lower() for part in _PART.findall(run)]
            for word in self.words:
                pieces = word.split("_")
                spans = (parts[i : i + len(pieces)] for i in range(len(parts) - len(pieces) + 1))
                if any(all(map(fnmatchcase, span, pieces)) for span in spans):
                    yield run


def _rule(words: str, instead: str, *, names_only: bool = False, allowed: tuple[str, ...] = ()) -> Rule:
    return Rule(tuple(words.split()), instead, names_only, allowed)


RETIRED = (
    _rule("blow blows", "hit"),
    _rule("rail rails", "full scale"),
    _rule("desk desks", "controller"),
    _rule("book books", "repository, campaign", names_only=True),
    _rule("wish wishes wished", "request, requested"),
    _rule(
        "silence silences silenced silent silently",
        "pre-trigger noise, time-out, without notice, no sign of life",
        allowed=("silence_logs", "--silent"),
    ),
    _rule("quiet*", "settled, undisturbed, low-noise, less busy", allowed=("--quiet",)),
    _rule("told untold", "reported, notified, known, stated"),
    _rule("tell tells teller", "notify, report", names_only=True),
    _rule("faith", "trust, confidence"),
    _rule("seat seats", "place"),
    _rule("course courses", "drift curve", names_only=True),
    _rule("visit visits visited", "session"),
    _rule("leftover leftovers", "residual, excluded"),
    _rule("isolability", "distinguishability"),
    _rule("refus*", "reject, rejected, rejection", allowed=("ConnectionRefusedError", "connection refused")),
    _rule("n_rest", "number of residual terms, or what it counts", names_only=True),
    _rule("beyond", "out of band, above, exceeding", names_only=True),
    _rule(
        "heard hears bent unbent worth lows calm faint",
        "audible, recorded, deformed, strained, cost, minima, normal",
        names_only=True,
    ),
    _rule("foretell* foretold", "predict, predicted"),
)


def check(path: str, text: str, rules: list[Rule]) -> list[str]:
    """What is wrong in one file: `path:line: word -> say instead`. The path counts as a name, at line 1."""
    rules = [rule for rule in rules if rule.hint.search(path) or rule.hint.search(text)]
    if not rules:
        return []
    old = _old_names(text) if path.endswith(".py") else _old_section(text)
    names, lines = _names(path, text), list(enumerate(text.splitlines(), start=1))
    wrong: list[str] = []
    for rule in rules:
        wrong += [f"{path}:1: {word} (in the path) -> {rule.instead}" for word in rule.found_in(path)]
        sought = names if rule.names_only else lines
        wrong += [
            f"{path}:{n}: {word} -> {rule.instead}" for n, t in sought if n not in old for word in rule.found_in(t)
        ]
    return wrong


def _names(path: str, text: str) -> list[tuple[int, str]]:
    """(line, name) of the identifiers of Python and of the fields of JSON; other files have none."""
    if path.endswith(".py"):
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        names = [(token.start[0], token.string) for token in tokens if token.type == tokenize.NAME]
        return [(line, name) for line, name in names if not name.startswith("test_")]
    if path.endswith(".json"):
        return [(n, name) for n, line in enumerate(text.splitlines(), start=1) for name in _FIELD.findall(line)]
    return []


def _old_names(text: str) -> set[int]:
    """Lines of the tables of names of earlier versions."""
    lines: set[int] = set()
    if OLD_NAMES not in text.lower():
        return lines
    for node in ast.walk(ast.parse(text)):
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if any(isinstance(t, ast.Name) and t.id.lower() == OLD_NAMES for t in targets):
            lines.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return lines


def _old_section(text: str) -> set[int]:
    """Lines of the sections of a page that list names of earlier versions."""
    lines: set[int] = set()
    inside = False
    for n, line in enumerate(text.splitlines(), start=1):
        inside = line.strip() == OLD_SECTION if line.startswith("## ") else inside
        if inside:
            lines.add(n)
    return lines


def files(root: Path) -> Iterator[Path]:
    """The files of the project that are looked at."""
    for start in LOOKED_AT:
        place = root / start
        for file in [place] if place.is_file() else sorted(place.rglob("*")):
            name = file.relative_to(root).as_posix()
            if (
                file.is_file()
                and file.suffix in SUFFIXES
                and "__pycache__" not in name
                and not name.startswith(LEFT_OUT)
            ):
                yield file


def main(arguments: list[str]) -> int:
    """Check the project, or lower what is allowed; the number of the exit."""
    if arguments == ["--lower"]:
        check_pages.lower(ROOT)
        return 0
    wrong = [
        line
        for file in files(ROOT)
        for line in check(file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8"), list(RETIRED))
    ]
    wrong += check_pages.problems(ROOT)
    print(*wrong, sep="\n" if wrong else "")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
