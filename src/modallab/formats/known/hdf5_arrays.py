"""HDF5 files of other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.campaign.hdf5_access import is_campaign, is_hdf5

    return is_hdf5(head) and not is_campaign(path)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.arrays.hdf5_arrays import read_hdf5_arrays

    return read_hdf5_arrays(path, rig, options)


def _draft(path: Path, options: ImportOptions) -> Rig:
    from modallab.formats.arrays.hdf5_arrays import draft_hdf5_arrays

    return draft_hdf5_arrays(path, options)


FORMAT = Format(
    name="hdf5_arrays",
    title="HDF5 of other programs",
    description="datasets and attributes of HDF5: one dataset for each channel, or one for all",
    endings=(".hdf",),
    is_no="HDF5 file",
    holds=("records", "FRFs"),
    asks=("test", "drive_point", "volts", "rate_hz", "frequency_hz", "window_s", "variables", "array_map"),
    priority=9,
    fits=_fits,
    read=_read,
    draft=_draft,
)
