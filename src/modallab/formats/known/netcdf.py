"""What Rattlesnake streams."""

from __future__ import annotations

from typing import TYPE_CHECKING

from modallab.formats.format import Format

if TYPE_CHECKING:
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.arrays.netcdf import is_rattlesnake
    from modallab.formats.campaign.hdf5_access import is_hdf5

    return is_hdf5(head) and is_rattlesnake(path)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.arrays.netcdf import read_rattlesnake

    return read_rattlesnake(path, rig, options)


FORMAT = Format(
    name="netcdf",
    title="netCDF4 of Rattlesnake",
    description="time records as Rattlesnake streams them: channels by node and direction",
    endings=(".nc4", ".nc"),
    is_no="netCDF4 file of Rattlesnake",
    holds=("records",),
    asks=("test", "drive_point", "volts", "frequency_hz"),
    priority=7,
    fits=_fits,
    read=_read,
)
