"""Reads and writes the files of others, and campaigns as one file."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazy_getattr

if TYPE_CHECKING:
    from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
    from modallab.formats.csv.csv_frf import read_csv_modes
    from modallab.formats.exporter import write_export
    from modallab.formats.format import all_formats, readers, writers
    from modallab.formats.importer import import_sources
    from modallab.formats.options import ImportOptions
    from modallab.formats.rig.rig_file import read_rig, write_rig
    from modallab.formats.sep005.sep005 import to_sep005
    from modallab.formats.uff.uff_shapes import read_uff_shapes

__all__ = [
    "ImportOptions",
    "all_formats",
    "import_sources",
    "read_campaign",
    "read_csv_modes",
    "read_rig",
    "read_uff_shapes",
    "readers",
    "to_sep005",
    "write_campaign",
    "write_export",
    "write_rig",
    "writers",
]

__getattr__ = lazy_getattr(
    __name__,
    {
        "campaign.campaign_hdf5": ("read_campaign", "write_campaign"),
        "csv.csv_frf": ("read_csv_modes",),
        "exporter": ("write_export",),
        "format": ("all_formats", "readers", "writers"),
        "importer": ("import_sources",),
        "options": ("ImportOptions",),
        "rig.rig_file": ("read_rig", "write_rig"),
        "sep005.sep005": ("to_sep005",),
        "uff.uff_shapes": ("read_uff_shapes",),
    },
)
