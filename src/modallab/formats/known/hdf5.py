"""Campaigns as one HDF5 file: everything as it was delivered, with checksums."""

from pathlib import Path

from modallab.formats.campaign import CAMPAIGN_FILE
from modallab.formats.format import Format, deferred


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.campaign.hdf5_access import is_hdf5

    return is_hdf5(head)


FORMAT = Format(
    name="hdf5",
    title="a campaign in HDF5",
    description="a campaign: everything as it was delivered, with checksums",
    endings=(".h5", ".hdf5"),
    is_no="HDF5 file",
    holds=("records", "FRFs"),
    asks=("drive_point",),
    several_forces=True,
    priority=10,
    fits=_fits,
    inside=CAMPAIGN_FILE,
    read=deferred("campaign.campaign_hdf5:import_campaign"),
    write=deferred("campaign.campaign_hdf5:write_campaign"),
)
