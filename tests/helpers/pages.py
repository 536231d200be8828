"""The pages of the project and the fenced blocks in them."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md")))

_FENCE = re.compile(r"^```(\w*)$")
RUN = {"bash", "console", "py", "python", "sh"}
"""Languages of the blocks that are commands or programs."""
HOW_TO = "docs/how-to/"
ELSEWHERE = {
    HOW_TO + "add-a-driver.md": "tests/contract/conftest.py",
    HOW_TO + "add-a-resource.md": "tests/service/api/test_add_a_resource.py",
    "docs/tutorial/rest-service.md": "tests/service/process/test_tutorial.py",
}
"""Pages whose blocks are run by tests of their own. Blocks that ask a service are run by `test_service_blocks.py`."""

_SERVICE = re.compile(r"\$LAB\b|\blab\.|\bClient\(")
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


def to_run(page: Path) -> list[Fenced]:
    """The blocks of a page that a test must run, or that say why not."""
    return [block for block in fenced(page) if block.language in RUN]


def needs_service(block: Fenced) -> bool:
    """Whether a block asks a running service."""
    return _SERVICE.search("\n".join(block.lines)) is not None


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
