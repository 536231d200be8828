"""The reference pages are complete: every option, field, unit, error and address of the program stands there."""

import argparse
import re
from collections.abc import Iterator
from importlib import import_module
from importlib.metadata import entry_points

import pytest
from pages import ROOT, prose

from modallab.cli.parser import build_parser
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel
from modallab.core.units import TO_SI
from modallab.formats.rig.messages import SECTIONS

REFERENCE = ROOT / "docs" / "reference"


def commands(parser: argparse.ArgumentParser, path: str = "modallab") -> Iterator[tuple[str, argparse.ArgumentParser]]:
    yield path, parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, sub in action.choices.items():
                yield from commands(sub, f"{path} {name}")


@pytest.mark.parametrize(
    ("path", "parser"), list(commands(build_parser("0"))), ids=lambda v: v if isinstance(v, str) else ""
)
def test_every_option_of_every_command_is_there(path: str, parser: argparse.ArgumentParser) -> None:
    text = prose(REFERENCE / "command-line.md")
    shared = text.split("## Options of several commands")[1].split("\n## ")[0]
    if path != "modallab":
        assert f"## `{path}`" in text
        text = text.split(f"## `{path}`")[1].split("\n## ")[0]
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction) or (path != "modallab" and action.dest == "help"):
            continue
        row = _row(text, action) or _row(shared, action)
        assert row, f"{path}: {action.dest} is not there"
        for choice in action.choices or ():
            assert str(choice) in row
        if action.default not in (None, False, "", argparse.SUPPRESS):
            assert str(action.default) in row


def test_no_option_is_there_that_does_not_exist() -> None:
    known = {o for _, p in commands(build_parser("0")) for action in p._actions for o in action.option_strings}
    said = set(re.findall(r"`(--?[a-z][\w-]*)", prose(REFERENCE / "command-line.md")))
    assert said <= known


def _row(text: str, action: argparse.Action) -> str:
    names = action.option_strings or [str(action.metavar or action.dest)]
    rows = [line.replace("\\|", "|") for line in text.splitlines() if line.startswith("| `")]
    return next((row for row in rows if all(f"`{name}" in row.split(" | ")[0] for name in names)), "")


def test_every_field_of_the_modal_model_is_there() -> None:
    said = set(re.findall(r"^\| `(\w+)` \|", prose(REFERENCE / "modal-model.md"), re.MULTILINE))
    document = {"code_version", "source", "rig", "provenance", "models", "assessments", "comparisons", "without_model"}
    assert said == set(ModalModel.model_fields) | document | {"frac"}


@pytest.mark.parametrize("section", SECTIONS)
def test_every_field_of_a_rig_is_there(section: str) -> None:
    text = prose(REFERENCE / "rig-file.md")
    missing = [field for field in SECTIONS[section].model_fields if f"`{field}`" not in text and field != "meaning"]
    assert not missing


def test_every_unit_is_there_with_its_factor() -> None:
    text = prose(REFERENCE / "units.md")
    for quantity, units in TO_SI.items():
        row = next(line for line in text.splitlines() if line.startswith(f"| {quantity} |"))
        for unit, factor in units.items():
            assert (f"{unit} {factor:.15g}" if factor != 1 else unit) in row, (quantity, unit)


def test_every_error_is_there_with_its_code() -> None:
    for module in (
        "modallab.acquisition.process.rig_process",
        "modallab.cli.demo_results",
        "modallab.cli.serve",
        "modallab_drivers.replay",
    ):
        import_module(module)
    said = dict(re.findall(r"^\| `([\w-]+)` \| `(\w+)` \|", prose(REFERENCE / "errors.md"), re.MULTILINE))
    own = [kind for kind in _kinds(ModallabError) if kind.__module__.startswith("modallab")]
    # A driver's own kind of an error has that error's code.
    assert said == {kind.code: kind.__name__ for kind in own if "code" in vars(kind)}


def _kinds(kind: type[ModallabError]) -> list[type[ModallabError]]:
    return [kind, *(found for sub in kind.__subclasses__() for found in _kinds(sub))]


def test_every_address_is_there() -> None:
    text = prose(REFERENCE / "bench-addresses.md")
    schemes = {entry.name for entry in entry_points(group="modallab.backends")}
    assert schemes == set(re.findall(r"^\| `([\w+]+)://", text, re.MULTILINE))


def test_every_parameter_of_the_simulated_bench_is_there() -> None:
    from modallab.core.errors import ConfigurationError
    from modallab_simulators.cantilever.address import parse

    with pytest.raises(ConfigurationError) as caught:
        parse("sim://cantilever?nonsense=1")
    known = set(str(caught.value).split("allowed: ")[1].splitlines()[0].split(", "))
    text = prose(REFERENCE / "bench-addresses.md").split("## `sim://cantilever`")[1]
    assert set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)) == known
