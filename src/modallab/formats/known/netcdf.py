"""What Rattlesnake streams."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.arrays.netcdf import is_rattlesnake
    from modallab.formats.campaign.hdf5_access import is_hdf5

    return is_hdf5(head) and is_rattlesnake(path)


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
    read=deferred("arrays.netcdf:read_rattlesnake"),
)
