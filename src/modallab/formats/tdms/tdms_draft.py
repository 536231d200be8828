"""A rig from the channels of a TDMS file."""

from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.draft import Said, rig_of
from modallab.formats.tdms.tdms_records import groups_of
from modallab.formats.unit_text import normal_unit, quantity_of


def draft_tdms(path: Path) -> Rig:
    """The rig of a TDMS file: the channels of its first group, by their names and unit_string.

    Raises:
        FormatError: no TDMS file, cut off, or of a kind that is not read here.
        DataError: it holds no samples.
    """
    groups, _ = groups_of(path)
    if not groups:
        raise DataError("holds no samples", where=str(path), remedy="export the records again")
    said: list[Said] = []
    for name, found in next(iter(groups.values())).items():
        unit = normal_unit(str(found.properties.get("unit_string", "")))
        said.append(Said(name, quantity_of(unit), unit))
    return rig_of(said, path)
