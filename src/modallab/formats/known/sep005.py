"""SEP005 time series of SDyPy, as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.model import ModalModel
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    return head.lstrip().startswith(b"[") and path.suffix.lower() == ".json"


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.sep005.sep005 import read_sep005

    return read_sep005(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.sep005.sep005_draft import draft_sep005

    return draft_sep005(path, options)


def _write(campaign: Campaign, path: Path, models: Sequence[ModalModel]) -> None:
    from modallab.formats.sep005.sep005 import write_sep005

    write_sep005(campaign, path)


FORMAT = Format(
    name="sep005",
    title="SEP005 in JSON",
    description="a list of time series with name, unit and rate, as SDyPy has it",
    endings=(".json",),
    is_no="JSON list of time series",
    holds=("records",),
    asks=("test", "drive_point", "volts", "frequency_hz", "variables"),
    priority=40,
    fits=_fits,
    read=_read,
    draft=_draft,
    write=_write,
)
