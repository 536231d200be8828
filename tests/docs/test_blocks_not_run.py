"""No block of a page is left out unnoticed: each is run by a test, or says in the page's source why not."""

import re
import shlex
from pathlib import Path

import pytest
from pages import ELSEWHERE, HOW_TO, PAGES, ROOT, Fenced, fenced, name, to_run

from modallab.cli.parser import build_parser

NOT_RUN = {
    "README.md": ["changes the terminal and the user's folders", "needs Windows and a network", "runs this very test"],
    "docs/explanation/uncertainty.md": ["takes hours"],
    "docs/explanation/simulated-bench.md": ["takes minutes"],
    HOW_TO + "check-the-diagnosis.md": ["needs a campaign of yours", "takes hours"],
    HOW_TO + "first-connection.md": ["needs somebody at the sensor"],
    HOW_TO + "run-on-a-server.md": ["needs Docker"],
    HOW_TO + "run-the-service.md": ["opens the service to the network"],
    "docs/tutorial/first-test.md": ["needs a network"],
}
"""Blocks that no test runs. Add one only if nothing here can run it."""


def test_no_block_is_left_out_without_a_reason() -> None:
    left_out = {name(p): sorted(b.not_run for b in to_run(p) if b.not_run) for p in PAGES}
    assert {page: why for page, why in left_out.items() if why} == NOT_RUN


@pytest.mark.parametrize("page", [p for p in PAGES if "decisions" not in p.parts], ids=name)
def test_commands_stand_in_fenced_blocks(page: Path) -> None:
    inside = {line for block in fenced(page) for line in block.lines}
    lines = page.read_text(encoding="utf-8").splitlines()
    assert not [line for line in lines if re.match(r" {4}(?:modallab [a-z]|python )", line) and line not in inside]


@pytest.mark.parametrize("block", [b for p in PAGES for b in to_run(p) if b.not_run], ids=lambda b: b.place)
def test_what_is_not_run_could_be(block: Fenced) -> None:
    """Its commands, options and scripts are there."""
    for line in block.lines:
        words = [word.replace("\\", "/") for word in shlex.split(line.removeprefix("$ "), comments=True)]
        while words and re.match(r"[A-Z_]+=", words[0]):
            words = words[1:]
        if words and Path(words[0]).name == "modallab":
            build_parser("0").parse_args(words[1:])
        for script in (word for word in words if re.fullmatch(r"[\w/]+\.(?:py|sh)", word)):
            assert (ROOT / script).is_file() or (ROOT / "docker" / script).is_file(), script


@pytest.mark.parametrize(("page", "test"), ELSEWHERE.items())
def test_a_page_that_is_run_elsewhere_is_named_there(page: str, test: str) -> None:
    assert Path(page).name in (ROOT / test).read_text(encoding="utf-8")
