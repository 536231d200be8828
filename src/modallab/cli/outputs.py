"""What a command is to write, looked at before it begins: an hour of measuring must not end at a misspelt folder.

No output may replace what the command reads, nor a recording, unless it is one itself.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import cast

from modallab.core.errors import StorageError

OUT = Path("-")
"""Given as a file for JSON: standard output."""
INPUTS = (
    "campaign", "sources", "source", "rig", "plan", "diagnosis", "on", "simulation", "models", "data", "backup",
    "folder", "truth",
)  # fmt: skip
"""Names of options and arguments that are read."""
OUTPUTS = ("out", "json", "report", "as_campaign")
"""Names of options that are written, each a file unless the command says `out_is_folder`, or it is CSV."""
INSIDE = ("campaign.h5", "rig.yaml")
"""What is read of a folder that is named."""
HDF5 = b"\x89HDF\r\n\x1a\n"


def check_outputs(arguments: argparse.Namespace) -> None:
    """Reject an output that cannot be written, or would replace what must not be lost.

    Raises:
        StorageError: the output is a folder, its folder is missing, or it is an input or a recording.
    """
    given = vars(arguments)
    if given.get("out_is_folder") or given.get("format") == "csv":
        _check_folder(given["out"])
        return
    for name in OUTPUTS:
        path = given.get(name)
        if isinstance(path, Path) and path != OUT:
            _check(f"--{name.replace('_', '-')}", path, given)


def _check_folder(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise StorageError("is a file", where=str(path), remedy="name a folder for the results")


def _check(option: str, path: Path, given: dict[str, object]) -> None:
    if path.is_dir():
        raise StorageError("is a folder", where=str(path), remedy=f"give {option} the name of a file in that folder")
    if not path.parent.is_dir():
        raise StorageError(
            f"cannot be written: there is no folder {path.parent}", where=str(path), remedy="make the folder first"
        )
    if not path.exists():
        return
    if not given.get("in_place") and any(source.exists() and source.samefile(path) for source in _inputs(given)):
        raise StorageError(
            "is one of the sources and would be overwritten", where=str(path), remedy=f"give {option} another name"
        )
    if option != "--out" and option != "--as-campaign" and _is_recording(path):
        raise StorageError(
            "is a recording and would be overwritten", where=str(path), remedy=f"give {option} another name"
        )


def _inputs(given: dict[str, object]) -> Iterator[Path]:
    for name in INPUTS:
        value = given.get(name)
        for path in cast("list[object]", value) if isinstance(value, list) else [value]:
            if isinstance(path, Path):
                yield path
                yield from (path / inside for inside in INSIDE if path.is_dir())


def _is_recording(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(HDF5)) == HDF5
