"""HDF5 files of other programs."""

from pathlib import Path

from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.campaign.hdf5_access import is_campaign, is_hdf5

    return is_hdf5(head) and not is_campaign(path)


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
    read=deferred("arrays.hdf5_arrays:read_hdf5_arrays"),
    draft=deferred("arrays.hdf5_arrays:draft_hdf5_arrays"),
)
