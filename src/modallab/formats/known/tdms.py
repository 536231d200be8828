"""TDMS files of LabVIEW and DIAdem."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format
from modallab.formats.tdms.tdms_types import TAG

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.model import ModalModel
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    return head.startswith(TAG)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.tdms.tdms_records import read_tdms

    return read_tdms(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.tdms.tdms_draft import draft_tdms

    return draft_tdms(path, options)


def _write(campaign: Campaign, path: Path, models: Sequence[ModalModel]) -> None:
    from modallab.formats.tdms.tdms_write import write_tdms

    write_tdms(campaign, path)


FORMAT = Format(
    name="tdms",
    title="TDMS",
    description="files of LabVIEW and DIAdem: a group a record, counts with their scale",
    endings=(".tdms",),
    is_no="TDMS file",
    holds=("records",),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "variables", "group"),
    priority=30,
    fits=_fits,
    read=_read,
    draft=_draft,
    write=_write,
)
