"""Every command and its options, in one place, without importing what they do."""

import argparse
from pathlib import Path
from typing import Any, Protocol


class _Commands(Protocol):
    # argparse gives its own class for this no public name.
    def add_parser(self, name: str, *, help: str) -> Any: ...  # noqa: A002


def build_parser(version: str) -> argparse.ArgumentParser:
    """The parser; each command names the module of `modallab.cli` that runs it."""
    parser = argparse.ArgumentParser(
        prog="modallab", description="Modal tests on a cantilever: run them, identify the modal model, explain the gap."
    )
    parser.add_argument("--version", action="version", version=f"modallab {version}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    _add_demo(commands)
    _add_import(commands)
    _add_identify(commands)
    return parser


def _add_demo(commands: _Commands) -> None:
    demo = commands.add_parser("demo", help="run a whole modal test on the simulated bench")
    demo.add_argument("--out", type=Path, default=Path("demo"), metavar="FOLDER", help="where the results go")
    demo.add_argument("--seed", type=int, default=1, help="seed of the simulated bench")
    demo.set_defaults(module="demo")


def _add_import(commands: _Commands) -> None:
    command = commands.add_parser("import", help="turn recordings of others into one campaign file")
    command.add_argument("sources", type=Path, nargs="+", metavar="SOURCE", help="UFF 58/58b, NPY, CSV or HDF5")
    command.add_argument("--rig", type=Path, required=True, metavar="RIG.yaml")
    command.add_argument("--out", type=Path, required=True, metavar="CAMPAIGN.h5")
    command.add_argument("--test", choices=("impact", "sine"), default="impact", help="what the recordings are of")
    command.add_argument("--rate", type=float, metavar="HZ", help="sampling rate, for files without times")
    command.add_argument("--drive-point", type=int, metavar="N", help="point of the blow or of the shaker")
    command.add_argument("--volts", action="store_true", help="numbers without a unit are volts")
    command.set_defaults(module="import_")


def _add_identify(commands: _Commands) -> None:
    command = commands.add_parser("identify", help="identify the modal model of a campaign")
    command.add_argument("campaign", type=Path, metavar="FOLDER|CAMPAIGN.h5")
    command.add_argument("--rig", type=Path, metavar="RIG.yaml", help="if it is neither inside nor beside the campaign")
    command.add_argument("--method", choices=("peak", "plscf"), default="plscf")
    command.add_argument("--test", choices=("impact", "sine"), help="only this test (default: every test there is)")
    command.add_argument("--band", type=float, nargs=2, metavar=("LO", "HI"), help="band in Hz")
    command.add_argument("--json", type=Path, metavar="FILE", help="write the models as JSON")
    command.add_argument("--report", type=Path, metavar="FILE", help="write a self-contained HTML report")
    command.set_defaults(module="identify")
