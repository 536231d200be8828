"""A rig from the series of a SEP005 file."""

from pathlib import Path

from modallab.core.rig import Rig
from modallab.formats.draft import Said, rig_of, wanted
from modallab.formats.options import ImportOptions
from modallab.formats.sep005.sep005 import series_of
from modallab.formats.unit_text import normal_unit, quantity_of


def draft_sep005(path: Path, options: ImportOptions) -> Rig:
    """The rig of a SEP005 file: the series of its first group, by their names and units.

    Raises:
        FormatError: no list of series.
    """
    said: list[Said] = []
    for name, series in next(iter(series_of(path).values())).items():
        unit = normal_unit(str(series["unit_str"]))
        said.append(Said(name, quantity_of(unit), unit))
    return rig_of(wanted(said, options), path)
