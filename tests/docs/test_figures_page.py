"""The page of figures is made from its rows, and a row says what it is."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest
from pages import ROOT

ROW = {
    "figure": "modes found",
    "value": "8 of 8",
    "goal": "",
    "date": "2026-11-25",
    "commit": "",
    "seed": "1",
    "seen": "unseen",
    "machine": "2 cores",
    "command": "python benchmarks/x.py",
    "page": "headline",
    "note": "",
}


@pytest.fixture(scope="module")
def figures() -> ModuleType:
    spec = importlib.util.spec_from_file_location("figures_page", ROOT / "benchmarks/results/page.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_page_is_that_of_the_figures(figures: ModuleType) -> None:
    assert figures.main(["--check"]) == 0, "run python benchmarks/results/page.py"


def test_the_newest_row_of_a_figure_counts(figures: ModuleType) -> None:
    def row(day: str, value: str) -> object:
        return figures.Figure(**{**ROW, "date": day, "value": value})

    rows = [row("2026-11-25", "old"), row("2026-11-26", "new"), row("2026-11-24", "older"), row("2026-11-26", "last")]
    assert [r.value for r in figures.newest(rows)] == ["last"]


def test_headline_comes_first_with_its_note(figures: ModuleType) -> None:
    row = figures.Figure(**{**ROW, "note": "not blind"})
    text = figures.page({"gap": [row, figures.Figure(**{**ROW, "figure": "far below", "page": "yes"})]})
    assert text.index("not blind") < text.index("## The gap") < text.index("far below")


@pytest.mark.parametrize(
    "wrong", [{"command": ""}, {"value": ""}, {"seen": "blind"}, {"page": "top"}, {"date": "25 November"}]
)
def test_a_row_that_does_not_say_what_it_is_is_rejected(figures: ModuleType, wrong: dict[str, str]) -> None:
    with pytest.raises(ValueError, match=r"modes found|isoformat"):
        figures.Figure(**{**ROW, **wrong})


def test_a_file_of_other_columns_is_rejected(figures: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("figure,value\na,1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="columns"):
        figures.read(tmp_path / "x.csv")


def test_a_figure_by_a_program_that_changed_is_not_unseen(figures: ModuleType) -> None:
    rows = [row for topic in figures.TOPICS for row in figures.read(figures.HERE / f"{topic}.csv")]
    assert not [row.figure for row in rows if "program was changed" in row.note and row.seen != "seen"]
