"""LabVIEW measurement files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions

_FIRST = b"LabVIEW Measurement"


def _fits(head: bytes, path: Path) -> bool:
    if head.removeprefix(b"\xef\xbb\xbf").startswith(_FIRST):
        return True
    # LabVIEW can leave the headers out: the rest is a table.
    return path.suffix.lower() == ".lvm" and all(byte >= 32 or byte in b"\t\r\n" for byte in head)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.lvm.lvm import campaign_of_lvm

    return campaign_of_lvm(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.lvm.lvm import draft_lvm

    return draft_lvm(path, options)


FORMAT = Format(
    name="lvm",
    title="LabVIEW measurement file (.lvm)",
    description="a measurement file of LabVIEW as text: a segment a record",
    endings=(".lvm",),
    is_no="measurement file of LabVIEW",
    holds=("records",),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "variables", "columns"),
    priority=25,
    fits=_fits,
    read=_read,
    draft=_draft,
)
