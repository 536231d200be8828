"""The map of the house names only what is there."""

import re
from importlib import import_module
from pathlib import Path

import pytest
from pages import ROOT, prose

PAGE = ROOT / "docs" / "explanation" / "architecture.md"
SOURCE = ROOT / "src" / "modallab"
NAMES = sorted({f"modallab.{name}" for name in re.findall(r"`(\w+(?:\.\w+)+)`", prose(PAGE))})


def exists(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    parent, _, last = name.rpartition(".")
    return SOURCE.parent.joinpath(*name.split(".")).with_suffix(".py").is_file() or hasattr(import_module(parent), last)


@pytest.mark.parametrize("name", NAMES)
def test_every_function_on_the_map_is_there(name: str) -> None:
    assert exists(name)


def test_the_map_follows_both_ways() -> None:
    assert len(NAMES) > 40


def test_every_folder_is_on_the_map_and_every_folder_on_it_is_there() -> None:
    rows = re.findall(r"^\| (`[^|]*`) \| (.*) \|$", prose(PAGE), re.MULTILINE)
    named = {folder: text for cell, text in rows for folder in re.findall(r"`(\w+)`", cell)}
    assert set(named) == _folders(SOURCE)
    for folder, text in named.items():
        said = {part for part in re.findall(r"`(\w+)`", text) if (SOURCE / folder / part).is_dir()}
        divided = _folders(SOURCE / folder) if folder in {"acquisition", "identification", "gap", "service"} else said
        assert said == divided, folder


def _folders(of: Path) -> set[str]:
    return {p.parent.name for p in of.glob("*/__init__.py")}
