"""The lines above the numbers of a table: names of the columns, their units, and what else a program writes there."""

import re
from collections.abc import Sequence

from modallab.core.errors import DataError
from modallab.formats.csv.csv_cells import BLANKS, head_cells, number
from modallab.formats.unit_text import frf_unit, normal_unit, quantity_of

_SQUARE = re.compile(r"^(?P<name>.*?)\s*\[(?P<unit>[^\[\]]*)\]\s*$")
_ROUND = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>.*)[\])]\s*$")
_OF_FREQUENCY = {"Hz", "hz", "HZ", "kHz", "rad/s"}
_OF_TIME = {"s", "ms", "us", "min", "h", "d"}
_OF_AXES = {*_OF_TIME, "%", *_OF_FREQUENCY, "deg", "rad", "dB", ""}
_UNIT_TAG = re.compile(r"unit|einheit", re.IGNORECASE)
TIME_NAMES = {"t", "time", "zeit", "temps", "tiempo", "tempo", "time_s", "t_s", "seconds", "sec", "x_time"}
FREQUENCY_NAMES = {
    "f",
    "freq",
    "frequency",
    "frequency_hz",
    "freq_hz",
    "f_hz",
    "hz",
    "frequenz",
    "frequence",
    "fréquence",
    "frecuencia",
    "frequenza",
}

BY_OPTION = 'name its columns with --columns "time,force:N,a01:m/s^2", or add a header line with their names'
"""What to do with a table without a header."""

Heads = tuple[tuple[str, ...], tuple[str, ...]]


def headings(above: Sequence[str], comments: Sequence[str], delimiter: str, columns: int) -> Heads:
    """Name and unit of each column, "" for a unit that is not written; () and () if the table has no header.

    Args:
        above: the lines above the numbers. The last with as many cells as there are columns holds the names, and one
            more below it units; of lines before it those count that begin with a word for units, and hold some.
        comments: comment lines above the numbers, without their mark; the last is a header if it begins as one does.
        delimiter: of the columns.
        columns: how many there are.
    """
    rows = [cells for line in above if len(cells := head_cells(line, delimiter, columns)) == columns]
    if delimiter == BLANKS:
        # Words and numbers side by side are no names.
        rows = [row for row in rows if all(number(cell) is None for cell in row)]
    elif above and not rows:
        # Of a table that is cut off or damaged: what stands first was meant to be the header.
        rows = [head_cells(above[0], delimiter, columns)]
    if not rows and comments:
        rows = [cells for line in comments[-2:] if len(cells := head_cells(line, delimiter, columns)) == columns]
        begins = [k for k, row in enumerate(rows) if _split(row[0])[0].lower() in TIME_NAMES | FREQUENCY_NAMES]
        rows = [row for row in rows[begins[-1] :] if row is rows[begins[-1]] or _are_units(row)] if begins else []
    if not rows:
        return (), ()
    names_row, units_row = _pair_of(rows, alone=len(above) == 2)
    parts = [_split(cell) for cell in names_row]
    names, units = tuple(name for name, _ in parts), tuple(unit for _, unit in parts)
    if units_row:
        units = tuple(unit or normal_unit(cell.strip("[]")) for unit, cell in zip(units, units_row, strict=True))
    tagged = _tagged([head_cells(line, delimiter, columns) for line in above], len(names))
    return names, tuple(unit or other for unit, other in zip(units, tagged, strict=True))


def said_headings(text: str, columns: int, where: str) -> Heads:
    """Name and unit of each column as the user says them: `time,force:N,a01:m/s^2`; units in brackets do as well.

    Raises:
        DataError: not one for each column.
    """
    cells = [cell.strip() for cell in text.split(",")]
    if len(cells) != columns:
        raise DataError(
            f"has {columns} columns, and --columns names {len(cells)}: {text!r}",
            where=where,
            remedy='name every column in its order, as "time,force:N,,a01:m/s^2"; one without a name is left out',
        )
    parts = [cell.rpartition(":")[::2] if ":" in cell else _split(cell) for cell in cells]
    return tuple(name.strip() for name, _ in parts), tuple(normal_unit(unit) for _, unit in parts)


def _pair_of(rows: Sequence[Sequence[str]], *, alone: bool) -> tuple[Sequence[str], Sequence[str]]:
    """The line of names and that of units, which stands below it or above; () if there is none.

    Names are distinct and no units. Loggers write more lines of one cell a column: stations, processing, rates.

    Args:
        rows: lines with a cell for each column, at least one.
        alone: whether two lines are all there is: the second then holds units, known or not.
    """
    last = len(rows) - 1
    if alone and last == 1 and not _are_units(rows[0]):
        return rows[0], rows[1]
    named = [k for k, row in enumerate(rows) if _are_names(row)]
    place = named[-1] if named else max(0, last - _are_units(rows[-1]))
    below = rows[place + 1] if place < last else ()
    if any(_is_unit(normal_unit(cell.strip("[]"))) for cell in below if cell):
        return rows[place], below
    above = rows[place - 1] if place else ()
    return rows[place], above if above and _are_units(above) else ()


def _are_names(row: Sequence[str]) -> bool:
    distinct = len({cell.casefold() for cell in row}) == len(row) and all(row[1:])
    return distinct and not _are_units(row)


def _tagged(rows: Sequence[Sequence[str]], columns: int) -> Sequence[str]:
    """The unit of each column from a line that says with its first cell that it holds units, "" without one.

    That cell stands before the units of all columns, or in the place of that of the first.
    """
    for row in rows:
        units = [normal_unit(cell) for cell in row[1:]]
        if row and _UNIT_TAG.search(row[0]) and any(quantity_of(unit) for unit in units):
            if len(units) == columns:
                return units
            if len(units) == columns - 1:
                return ["", *units]
    return [""] * columns


def time_column(names: Sequence[str], units: Sequence[str]) -> int | None:
    """The place of the column of times, by its name, or as the first one by its unit; None if there is none."""
    named = next((place for place, name in enumerate(names) if name.lower() in TIME_NAMES), None)
    return 0 if named is None and units and units[0] in _OF_TIME else named


def is_frequency(name: str, unit: str) -> bool:
    """Whether a column is one of frequencies, by its name or its unit."""
    return name.lower() in FREQUENCY_NAMES or unit in _OF_FREQUENCY


def _are_units(row: Sequence[str]) -> bool:
    found = [normal_unit(cell.strip("[]")) for cell in row]
    known = [not unit or _is_unit(unit) for unit in found]
    return all(known) and any(found) and all(number(cell) is None for cell in row)


def _is_unit(unit: str) -> bool:
    return bool(unit) and bool(unit in _OF_AXES or quantity_of(unit) or frf_unit(unit, ""))


def _split(heading: str) -> tuple[str, str]:
    """Name and unit of a heading: `force [N]`, `force (N)`, or a quantity over its unit, as ISO 80000 has it."""
    match = _SQUARE.match(heading) or _ROUND.match(heading)
    if match is not None:
        return match["name"].rstrip("/ "), normal_unit(match["unit"])
    name, _, unit = (part.strip() for part in heading.partition("/"))
    if name and _is_unit(normal_unit(unit)) and not _is_unit(name.split()[-1]):
        return name, normal_unit(unit)
    return heading.strip(), ""
