"""CSV tables."""

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

_ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc")


def _fits(head: bytes, path: Path) -> bool:
    return path.suffix.lower() in _ENDINGS or all(byte >= 32 or byte in b"\t\r\n\f" for byte in head)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.csv.csv_read import read_csv

    return read_csv(path, rig, options)


def _write(campaign: Campaign, path: Path, models: Sequence[ModalModel]) -> None:
    from modallab.formats.csv.csv_write import write_csv

    write_csv(campaign, path, models)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.csv.csv_draft import draft_csv

    return draft_csv(path, options)


FORMAT = Format(
    name="csv",
    title="CSV",
    description="a table as text: a column of times and one for each channel; a folder of them when written",
    endings=_ENDINGS,
    is_no="table as text",
    holds=("records", "FRFs", "modes"),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "window_s", "variables", "columns"),
    priority=60,
    certain=False,
    fits=_fits,
    read=_read,
    draft=_draft,
    write=_write,
)
