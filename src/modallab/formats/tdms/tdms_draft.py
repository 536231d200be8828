"""A rig from the channels of a TDMS file."""

from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.tdms.tdms_groups import chosen, fastest, is_time
from modallab.formats.tdms.tdms_read import read_tdms_groups
from modallab.formats.tdms.tdms_records import unit_in_properties
from modallab.formats.unit_text import quantity_of


def draft_tdms(path: Path, options: ImportOptions) -> Rig:
    """The rig of a TDMS file: the channels of its fastest group, or of the chosen one, by their names and units.

    Raises:
        FormatError: no TDMS file, cut off or damaged.
        DataError: it holds no samples.
    """
    groups = chosen(read_tdms_groups(path), options.group, str(path))
    groups = tuple(g for g in groups if any(not is_time(c) for c in g.channels.values()))
    if not groups:
        raise DataError("holds nothing but times", where=str(path), remedy="export the records again")
    drafts: list[DraftChannel] = []
    for channel in fastest(groups, str(path)):
        unit = unit_in_properties(channel)
        drafts.append(DraftChannel(channel.name, quantity_of(unit), unit))
    return rig_of(select_channels(drafts, options), path)
