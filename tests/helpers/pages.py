"""The pages of the project and the fenced blocks in them."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md")))

_FENCE = re.compile(r"^```(\w*)$")
_MARKER = re.compile(r"^<!-- not run: (.+) -->$")


@dataclass(frozen=True)
class Fenced:
    """A fenced block: its language, its lines, the line it begins at, and why no test runs it, if the page says so."""

    page: Path
    line: int
    language: str
    lines: tuple[str, ...]
    not_run: str = ""

    @property
    def place(self) -> str:
        return f"{name(self.page)}:{self.line}"


def name(page: Path) -> str:
    """A page's path inside the project."""
    return page.relative_to(ROOT).as_posix()


def fenced(page: Path) -> list[Fenced]:
    """The fenced blocks of a page, in order."""
    blocks: list[Fenced] = []
    language, start, lines = "", 0, list[str]()
    before = why = ""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        fence = _FENCE.match(line)
        if fence is None:
            lines.append(line)
        elif start:
            blocks.append(Fenced(page, start, language, tuple(lines), why))
            start = 0
        else:
            language, start, lines = fence[1], number, []
            marked = _MARKER.match(before)
            why = marked[1] if marked else ""
        before = line
    assert not start, f"{name(page)}:{start}: the block does not end"
    return blocks


def prose(page: Path) -> str:
    """A page without its fenced blocks."""
    kept: list[str] = []
    inside = False
    for line in page.read_text(encoding="utf-8").splitlines():
        if _FENCE.match(line):
            inside = not inside
        elif not inside:
            kept.append(line)
    return "\n".join(kept)
