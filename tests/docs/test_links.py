"""The pages hang together, and speak of the project only."""

import re
import runpy
from pathlib import Path

import pytest
from pages import PAGES, ROOT, fenced, name, prose

_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
_HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)
_MACHINE = re.compile(r"(?<![\w.])/(?:work|home|root|tmp|opt|usr|var|mnt|Users)/|\b[A-Z]:\\")
_HOST = re.compile(r"\b[\w-]+\.(?:org|com|io|net|dev)\b|--(?:extra-)?index-url", re.IGNORECASE)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_relative_link_leads_somewhere(page: Path) -> None:
    dead: list[str] = []
    for link in _LINK.findall(prose(page)):
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        if not target.is_relative_to(ROOT) or not target.exists() or (anchor and anchor not in _anchors(target)):
            dead.append(link)
    assert not dead


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_no_page_names_a_host_or_a_path_of_one_machine(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert not _MACHINE.findall(text)
    assert not _HOST.findall(text)


def test_every_page_can_be_found_from_the_index() -> None:
    index = ROOT / "docs" / "README.md"
    listed = {(index.parent / link).resolve() for link in _LINK.findall(prose(index))}
    pages = {p for p in PAGES if p.is_relative_to(index.parent) and p.parent.name != "decisions"} - {index}
    assert pages <= listed


def test_the_house_in_the_readme_is_the_house() -> None:
    named = re.findall(r"^\| (`.*?`) \|", prose(ROOT / "README.md"), re.MULTILINE)
    folders = [folder for row in named for folder in re.findall(r"`([^`]+)`", row)]
    assert len(folders) >= 10
    missing = [f for f in folders if not (ROOT / f).is_dir() and not (ROOT / "src/modallab" / f).is_dir()]
    assert not missing
    stages = {p.parent.name for p in (ROOT / "src/modallab").glob("*/__init__.py")}
    assert stages == {Path(f).name for f in folders} - {"drivers", "simulators"}


def test_pictures_are_small() -> None:
    pictures = [p for p in (ROOT / "docs/images").iterdir() if p.suffix in {".svg", ".png"}]
    assert pictures
    assert all(p.stat().st_size < 200_000 for p in pictures)


def test_decisions_are_numbered_once() -> None:
    pages = [page for page in (ROOT / "docs/decisions").glob("*.md") if page.name != "README.md"]
    numbers = [page.name[:4] for page in pages]
    assert all(number.isdigit() for number in numbers)
    assert len(set(numbers)) == len(numbers)
    for page in pages:
        assert page.read_text(encoding="utf-8").startswith(f"# {page.name[:4]}")


def test_the_index_of_decisions_lists_each() -> None:
    index = ROOT / "docs/decisions/README.md"
    filled = runpy.run_path(str(ROOT / "docs/made.py"))["filled"]
    listed = {link for link in _LINK.findall(filled(prose(index))) if "/" not in link}
    assert listed == {page.name for page in index.parent.glob("*.md")} - {"README.md"}


def test_every_fenced_block_names_its_language() -> None:
    assert not [block.place for page in PAGES for block in fenced(page) if not block.language]


def _anchors(page: Path) -> set[str]:
    """Anchors of the headings, as hosts of Markdown make them."""
    headings = _HEADING.findall(prose(page))
    return {re.sub(r"[^\w\- ]", "", heading).strip().lower().replace(" ", "-") for heading in headings}
