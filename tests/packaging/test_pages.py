"""Long sentences, shared class names and unneeded decisions are found, and what is allowed only shrinks."""

import shutil
from pathlib import Path

import check_pages
import pytest

LONG = " ".join(["word"] * 26)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (f"{LONG}.\n", 1),
        (f"{' '.join(['word'] * 25)}.\n", 0),
        (f"One: {LONG}. Two.\n", 1),
        ("Thirteen words " * 13 + ". " + "and more " * 12 + ".\n", 1),
        (f"```text\n{LONG}\n```\n", 0),
        (f"`{LONG}` is code.\n", 0),
        (f"# {LONG}\n", 0),
        (f"| {LONG} | short |\n|---|---|\n", 1),
        (f"- {' '.join(['word'] * 20)}\n- {' '.join(['word'] * 20)}\n", 0),
        (f"{' '.join(['word'] * 20)} [a link](to-{'-'.join(['many'] * 9)}.md) ends.\n", 0),
        (f"{' '.join(['1.5'] * 30)} numbers.\n", 0),
    ],
)
def test_a_sentence_is_long_above_25_words(text: str, found: int) -> None:
    assert len(check_pages.long_sentences(text)) == found


def test_a_public_class_in_two_files_is_found() -> None:
    texts = {"a.py": "class Zork: ...\nclass _Own: ...\n", "b.py": "class Zork(Base): ...\nclass _Own: ...\n"}
    assert check_pages.shared_names(texts) == ["Zork"]


def test_a_decision_that_nothing_refers_to_is_found() -> None:
    texts = ["see [why](../decisions/0001-a.md)", "no link"]
    assert check_pages.unneeded_decisions(["0001-a.md", "0002-b.md"], texts) == ["0002-b.md"]


@pytest.fixture
def house(tmp_path: Path) -> Path:
    for folder in ("docs/reference", "docs/decisions", "src", "drivers", "simulators"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "README.md").write_text(f"{LONG}. {LONG}.\n", encoding="utf-8")
    (tmp_path / "CHANGELOG.md").write_text("Short.\n", encoding="utf-8")
    allowed = '# Why.\nshared_names = ["Zork"]\n\n[long_sentences]\n"README.md" = 3\n'
    (tmp_path / check_pages.ALLOWED).write_text(allowed, encoding="utf-8")
    return tmp_path


def test_what_is_allowed_is_no_problem_and_can_be_lowered(house: Path) -> None:
    assert check_pages.problems(house) == []
    check_pages.lower(house)
    assert '"README.md" = 2\n' in (house / check_pages.ALLOWED).read_text(encoding="utf-8")
    assert "Zork" not in (house / check_pages.ALLOWED).read_text(encoding="utf-8")


def test_lowering_never_raises(house: Path) -> None:
    shutil.copy(house / "README.md", house / "docs" / "more.md")
    (house / "README.md").write_text(f"{LONG}. " * 9, encoding="utf-8")
    check_pages.lower(house)
    assert [line.split(":")[0] for line in check_pages.problems(house)] == ["README.md", "docs/more.md"]


def test_each_problem_is_said(house: Path) -> None:
    (house / "src" / "a.py").write_text("class Bench: ...\n", encoding="utf-8")
    (house / "src" / "b.py").write_text("class Bench: ...\n", encoding="utf-8")
    (house / "docs" / "decisions" / "0001-a.md").write_text("# 0001: A\n", encoding="utf-8")
    shared, unneeded = check_pages.problems(house)
    assert "Bench" in shared
    assert "0001-a.md" in unneeded
