"""The reference is complete: what the program makes of itself, and what its pages list by hand."""

import re
import runpy
from collections.abc import Callable
from importlib.metadata import entry_points

import pytest
from pages import PAGES, ROOT, prose

from modallab.core.units import TO_SI

REFERENCE = ROOT / "docs" / "reference"
MADE = runpy.run_path(str(ROOT / "docs/made.py"))
MARKED = [(page, mark) for page in PAGES for mark in MADE["MARK"].findall(page.read_text(encoding="utf-8"))]


def test_every_part_stands_on_a_page() -> None:
    assert {name for _, (name, _) in MARKED} == set(MADE["PARTS"])


@pytest.mark.parametrize(("page", "mark"), MARKED, ids=lambda v: v.stem if hasattr(v, "stem") else "-".join(v))
def test_every_part_can_be_made_and_leaves_no_meaning_out(page: object, mark: tuple[str, str]) -> None:
    part: Callable[..., str] = MADE["PARTS"][mark[0]]
    rows = [line for line in part(*filter(None, mark[1:])).splitlines() if line.startswith("| `")]
    empty = [row for row in rows if not row.removesuffix("|").rpartition(" | ")[2].strip()]
    assert not empty
    assert rows or mark[0] in {"python", "decisions"}


def test_all_that_is_offered_in_python_is_explained() -> None:
    heads = re.findall(r"^##.*\n\n(.*)", MADE["python"](), re.MULTILINE)
    assert len(heads) > 40
    assert all(heads)


def test_no_option_is_named_on_a_page_that_does_not_exist() -> None:
    known = set(re.findall(r"--[a-z][\w-]*", MADE["commands"]())) | {"--help", "--version"}
    said = set(re.findall(r"`modallab [^`\n]*?(--[a-z][\w-]*)", "\n".join(prose(page) for page in PAGES)))
    assert said <= known


def test_every_unit_is_there() -> None:
    text = prose(REFERENCE / "units.md").split("\n## ")[0]
    written = {"m/s2", "m/s**2"}
    missing = [
        unit for of in TO_SI.values() for unit in set(of) - written if not re.search(rf"\b{re.escape(unit)}\b", text)
    ]
    assert not missing


def test_every_address_is_there() -> None:
    text = prose(REFERENCE / "bench-addresses.md")
    schemes = {entry.name for entry in entry_points(group="modallab.backends")}
    assert schemes == set(re.findall(r"^\| `([\w+]+)://", text, re.MULTILINE))


def test_every_parameter_of_the_simulated_bench_is_there() -> None:
    from modallab.core.errors import ConfigurationError
    from modallab_simulators.cantilever.address import parse_address

    with pytest.raises(ConfigurationError) as caught:
        parse_address("sim://cantilever?nonsense=1")
    known = set(str(caught.value).split("allowed: ")[1].splitlines()[0].split(", "))
    text = prose(REFERENCE / "bench-addresses.md").split("## `sim://cantilever`")[1]
    assert set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)) == known
