"""Campaigns as one HDF5 file: everything as it was delivered, with checksums."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from modallab.formats.campaign import CAMPAIGN_FILE
from modallab.formats.format import Format

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from modallab.core.block import Campaign
    from modallab.core.model import ModalModel
    from modallab.core.rig import Rig
    from modallab.formats.options import ImportOptions


def _fits(head: bytes, path: Path) -> bool:
    from modallab.formats.campaign.hdf5_access import is_hdf5

    return is_hdf5(head)


def _read(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    from modallab.formats.campaign.campaign_hdf5 import read_campaign

    campaign, point = read_campaign(path, rig), options.drive_point
    blocks = (replace(b, drive_point=point) if b.drive_point is None else b for b in campaign.blocks)
    return replace(campaign, blocks=tuple(blocks))


def _write(campaign: Campaign, path: Path, models: Sequence[ModalModel]) -> None:
    from modallab.formats.campaign.campaign_hdf5 import write_campaign

    write_campaign(campaign, path)


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
    read=_read,
    write=_write,
)
