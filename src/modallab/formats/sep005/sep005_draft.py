"""A rig from the series of a SEP005 file."""

from pathlib import Path

from modallab.core.rig import Rig
from modallab.formats.draft import DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.sep005.sep005 import series_of
from modallab.formats.unit_text import normal_unit, quantity_of


def draft_sep005(path: Path, options: ImportOptions) -> Rig:
    """The rig of a SEP005 file: the series of its first group, by their names and units.

    Raises:
        FormatError: no list of series.
    """
    drafts: list[DraftChannel] = []
    for name, series in next(iter(series_of(path).values())).items():
        unit = normal_unit(str(series["unit_str"]))
        drafts.append(DraftChannel(name, quantity_of(unit), unit))
    return rig_of(select_channels(drafts, options), path)
