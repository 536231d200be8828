"""Universal files."""

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
    from modallab.formats.uff.uff_functions import DELIMITER

    return head.lstrip().splitlines()[0].strip() == DELIMITER


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.uff.uff_read import read_uff

    return read_uff(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.uff.uff_draft import draft_uff

    return draft_uff(path, options)


def _write(campaign: Campaign, path: Path, models: Sequence[ModalModel]) -> None:
    from modallab.formats.uff.uff_write import write_uff

    write_uff(campaign, path, models)


FORMAT = Format(
    name="uff",
    title="UFF 58 or 58b",
    description="a universal file: functions of dataset 58 as text or binary, shapes of dataset 55",
    endings=(".uff", ".unv", ".bunv", ".uf"),
    is_no="universal file: it does not begin with a line '    -1'",
    holds=("records", "FRFs", "modes"),
    asks=("test", "drive_point", "volts", "frequency_hz", "window_s"),
    priority=50,
    fits=_fits,
    read=_read,
    draft=_draft,
    write=_write,
)
