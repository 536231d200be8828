"""A campaign in the format of others, by the format's name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.csv.csv_write import write_csv
from modallab.formats.sep005.sep005 import write_sep005
from modallab.formats.tdms.tdms_write import write_tdms
from modallab.formats.uff.uff_write import write_uff

Format = Literal["hdf5", "uff", "csv", "sep005", "tdms"]


def write_export(campaign: Campaign, out: Path, format_: Format, models: Sequence[ModalModel] = ()) -> tuple[str, ...]:
    """Write a campaign, and models that were identified from it where the format holds such.

    Returns:
        what had no place in the format, in plain sentences.

    Raises:
        DataError: there is nothing that the format holds.
        StorageError, DiskFullError: it cannot be written.
    """
    left_out: list[str] = []
    if format_ in ("sep005", "tdms"):
        if not campaign.blocks:
            raise DataError(f"there are no time records, and {format_} holds nothing else", remedy="export as uff")
        if campaign.frfs:
            left_out.append(f"{format_} holds time records only; FRFs were left out")
    if models and format_ not in ("uff", "csv"):
        left_out.append(f"{format_} has no place for modal models; they were left out")
    if format_ == "uff":
        write_uff(campaign, out, models)
    elif format_ == "csv":
        write_csv(campaign, out, models)
    else:
        {"hdf5": write_campaign, "sep005": write_sep005, "tdms": write_tdms}[format_](campaign, out)
    return tuple(left_out)
