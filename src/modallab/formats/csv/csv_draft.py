"""A rig from the header of a table of time records."""

from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.csv.csv_read import TIME_NAMES
from modallab.formats.csv.csv_table import read_table
from modallab.formats.draft import Said, rig_of
from modallab.formats.unit_text import quantity_of


def draft_csv(path: Path) -> Rig:
    """The rig of a table: a channel for each column but the times, by its name and unit.

    Raises:
        FormatError: no table, or cut off.
        DataError: the table has no header.
    """
    table = read_table(path)
    if not table.names:
        raise DataError(
            "has no header, so that its columns have no names",
            where=str(path),
            remedy="add a header line with time and the names of the channels, or give a rig file with --rig",
        )
    units = table.units or ("",) * len(table.names)
    columns = [(n, u) for n, u in zip(table.names, units, strict=True) if n.lower() not in TIME_NAMES]
    return rig_of([Said(name, quantity_of(unit), unit) for name, unit in columns], path)
