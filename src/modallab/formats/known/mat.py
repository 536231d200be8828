"""MATLAB files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.arrays.mat import MARKS

    # Version 4 has no mark; SciPy knows it by a zero where the others have text.
    return head.startswith(MARKS) or (path.suffix.lower() == ".mat" and 0 in head[:4])


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.arrays.mat import read_mat

    return read_mat(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.arrays.mat import draft_mat

    return draft_mat(path, options)


FORMAT = Format(
    name="mat",
    title="MATLAB (.mat)",
    description="variables of MATLAB, version 4, 5 or 7.3: one for each channel, or one for all",
    endings=(".mat",),
    is_no="MATLAB file of version 4, 5 or 7.3",
    holds=("records", "FRFs"),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "window_s", "variables", "array_map"),
    priority=5,
    fits=_fits,
    read=_read,
    draft=_draft,
)
