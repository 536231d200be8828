"""A rig from the header of a table of time records or FRFs."""

from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.rig import Direction, Rig
from modallab.core.units import Quantity
from modallab.formats.csv.csv_frf_table import columns_of, holds_frfs
from modallab.formats.csv.csv_heads import BY_OPTION, time_column
from modallab.formats.csv.csv_table import Table, read_tables, side_by_side
from modallab.formats.csv.frf_heading import FrfHeading, pair_of
from modallab.formats.draft import MEASURED, DraftChannel, rig_of, select_channels
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import frf_unit, quantity_of

_DIRECTIONS: dict[str, Direction] = {"+x": "+x", "-x": "-x", "+y": "+y", "-y": "-y", "+z": "+z", "-z": "-z"}


def draft_csv(path: Path, options: ImportOptions) -> Rig:
    """The rig of a table: a channel for each column but the times, by its name and unit; for each response of an FRF.

    Raises:
        FormatError: no table, or cut off.
        DataError: the table has no header.
    """
    tables = read_tables(path, options.columns)
    table = side_by_side(tables, str(path)) if holds_frfs(tables[-1]) else tables[0]
    if not table.names:
        raise DataError(
            "has no header, so that its columns have no names",
            where=str(path),
            remedy=f"{BY_OPTION}; or give a rig file with --rig",
        )
    if holds_frfs(table):
        return _of_frfs(table, path, options)
    units = table.units or ("",) * len(table.names)
    time = time_column(table.names, table.units)
    columns = [(n, u) for k, (n, u) in enumerate(zip(table.names, units, strict=True)) if k != time and n]
    drafts = select_channels((DraftChannel(n, quantity_of(unit), unit) for n, unit in columns), options)
    numbers = [one for one in drafts if table.names.index(one.name) not in table.no_numbers]
    if not numbers:
        table.require([table.names.index(one.name) for one in drafts])
    return rig_of(numbers, path)


def _of_frfs(table: Table, path: Path, options: ImportOptions) -> Rig:
    headings = [c.heading for c in columns_of(table, None, str(path)) if c.heading.part not in ("phase", "coherence")]
    pairs = [pair_of(h.of) for h in headings]
    drives = {p.input for p in pairs if p.input is not None}
    responses: dict[str, DraftChannel] = {}
    for heading, pair in zip(headings, pairs, strict=True):
        name = pair.name or "response" if pair.point is None else f"p{pair.point}{pair.axis}"
        if name not in responses or responses[name].quantity is None:
            responses[name] = DraftChannel(name, _quantity(heading), "", pair.point, _DIRECTIONS.get(pair.axis))
    force = DraftChannel("force", "force", "N", min(drives) if len(drives) == 1 else None)
    return rig_of([force, *select_channels(responses.values(), options)], path, driven=drives)


def _quantity(heading: FrfHeading) -> Quantity | None:
    pair = frf_unit(heading.unit, "")
    return None if pair is None else MEASURED[pair[0]]
