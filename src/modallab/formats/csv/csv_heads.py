"""The lines above the numbers of a table: names of the columns, their units, and what else a program writes there."""

import re
from collections.abc import Sequence

from modallab.core.errors import DataError
from modallab.formats.csv.csv_cells import head_cells, is_number
from modallab.formats.csv.csv_facts import WHOSE, Facts
from modallab.formats.unit_text import is_of_frequency, is_of_time, is_unit, name_and_unit, normal_unit, quantity_of

_LETTER = re.compile(r"[^\W_]")
"""What a line of dashes has none of."""
_WORD = r"(?<![^\W_])(?:{})(?![^\W_])"
_TIME_WORD = re.compile(
    _WORD.format("t|time|timestamp|datetime|zeit|zeitstempel|temps|tiempo|tempo|seconds|sec"), re.IGNORECASE
)
_FREQUENCY_WORD = re.compile(
    _WORD.format("f|freq|frequency|hz|frequenz|fr[eé]quence|frecuencia|frequenza"), re.IGNORECASE
)

BY_OPTION = 'name its columns with --columns "time,force:N,a01:m/s^2", or add a header line with their names'
"""What to do with a table without a header."""

Heads = tuple[tuple[str, ...], tuple[str, ...]]


def headings(
    above: Sequence[str], commented: Sequence[str], delimiter: str, columns: int, filled: int, facts: Facts
) -> Heads:
    """Name and unit of each column, "" for a unit that is not written; () and () if the table has no header.

    Args:
        above: the lines above the numbers.
        commented: comments above the numbers, without their mark; they name the columns if one names the abscissa.
        delimiter: of the columns.
        columns: how many there are.
        filled: how many, without those at the end that are empty; they need no name.
        facts: that stand above, too.
    """
    rows = _fitting(above, delimiter, columns, filled)
    if not rows:
        rows = _fitting(commented, delimiter, columns, filled)
        rows = rows if any(_names_abscissa(row) for row in rows) else []
    # An index may have no name.
    words = [k for k, row in enumerate(rows) if _are_words(row) and all(row[1:filled])]
    place = max(words, key=lambda k: _evidence(rows, k), default=None)
    if place is None:
        return (), ()
    parts = [name_and_unit(cell) for cell in _with_abscissa(rows, place)]
    beside = _units_beside(rows, place, alone=len(above) == 2) or facts.units(columns)
    units = (unit or normal_unit(cell.strip("[]")) for (_, unit), cell in zip(parts, beside, strict=True))
    return tuple(name for name, _ in parts), tuple(map(facts.of_ratio, units))


def _with_abscissa(rows: Sequence[Sequence[str]], place: int) -> Sequence[str]:
    """The line of the names; with what a line above it says, where only that one names the abscissa."""
    row = _distinct(rows, place)
    above = next((one for one in reversed(rows[:place]) if _are_words(one) and _names_abscissa(one[:1])), None)
    if row[0] or above is None:
        return row
    return [f"{over} {cell}".strip() for over, cell in zip(above, row, strict=True)]


def _distinct(rows: Sequence[Sequence[str]], place: int) -> Sequence[str]:
    """The line of the names; where they repeat, each behind the cell above it, which may be merged over several."""
    row = rows[place]
    nearest = reversed(rows[:place] if not _are_names(row) else ())
    for above in sorted(nearest, key=lambda one: not WHOSE.match(one[0])):
        over = [next(filter(None, reversed(above[: k + 1])), "") for k in range(len(row))]
        joined = [row[0], *(f"{said} {cell}".strip() for said, cell in zip(over[1:], row[1:], strict=True))]
        if _are_names(joined) and not any(map(is_number, above)):
            return joined
    return row


def _fitting(lines: Sequence[str], delimiter: str, columns: int, filled: int) -> list[list[str]]:
    """The cells of the lines that have one for each column."""
    found: list[list[str]] = []
    for line in lines:
        cells = head_cells(line, delimiter, columns)
        while len(cells) > filled and not cells[-1]:
            cells.pop()
        drawn = not _LETTER.search(line)
        found += [cells + [""] * (columns - len(cells))] if filled <= len(cells) <= columns and not drawn else []
    return found


def _evidence(rows: Sequence[Sequence[str]], k: int) -> tuple[bool, bool, bool, int]:
    """What speaks for a line as that of the names: one is the abscissa's, units stand beside it, the last counts."""
    return _are_names(rows[k]), _names_abscissa(rows[k]), any(_units_beside(rows, k, alone=False)), k


def _names_abscissa(row: Sequence[str]) -> bool:
    return any(_TIME_WORD.search(name) or _FREQUENCY_WORD.search(name) for name, _ in map(name_and_unit, row))


def _units_beside(rows: Sequence[Sequence[str]], k: int, *, alone: bool) -> Sequence[str]:
    """The units in the line below that of the names, or above it; () if there are none.

    Args:
        rows: lines with a cell for each column.
        k: the place of the names.
        alone: whether two lines are all there is: the second then holds units, known or not.
    """
    below, above = rows[k + 1 : k + 2], rows[max(k - 1, 0) : k]
    if below and (alone or any(is_unit(normal_unit(cell.strip("[]"))) for cell in below[0] if cell)):
        return below[0]
    return above[0] if above and _are_units(above[0]) else ()


def _are_words(row: Sequence[str]) -> bool:
    return any(row) and not _are_units(row) and not any(map(is_number, row))


def _are_names(row: Sequence[str]) -> bool:
    """Whether words are distinct."""
    named = [cell.casefold() for cell in row if cell]
    return _are_words(row) and len(set(named)) == len(named)


def parse_headings(text: str, columns: int, filled: int, where: str) -> Heads:
    """Name and unit of each column as the user says them: `time,force:N,a01:m/s^2`; units in brackets do as well.

    Raises:
        DataError: not one for each column.
    """
    cells = [cell.strip() for cell in text.split(",")]
    if not filled <= len(cells) <= columns:
        raise DataError(
            f"has {filled} columns, and --columns names {len(cells)}: {text!r}",
            where=where,
            remedy='name every column in its order, as "time,force:N,,a01:m/s^2"; one without a name is left out',
        )
    cells += [""] * (columns - len(cells))
    parts = [cell.rpartition(":")[::2] if ":" in cell else name_and_unit(cell) for cell in cells]
    return tuple(name.strip() for name, _ in parts), tuple(normal_unit(unit) for _, unit in parts)


def abscissa(names: Sequence[str], units: Sequence[str]) -> int | None:
    """The place of the column of times or frequencies; None if there is none."""
    if names[0] and is_frequency(names[0], units[0]):
        return 0
    time = time_column(names, units)
    if time is not None:
        return time
    return next((k for k, pair in enumerate(zip(names, units, strict=True)) if is_frequency(*pair)), None)


def time_column(names: Sequence[str], units: Sequence[str]) -> int | None:
    """The place of the column of times, by its name, or as the first one by its unit; None if there is none."""
    pairs = list(zip(names, units or ("",) * len(names), strict=True))
    named = [k for k, (name, unit) in enumerate(pairs) if is_time_name(name) and not quantity_of(unit)]
    # Of several the first whose unit is known: whole numbers beside seconds may count anything.
    return next(iter(sorted(named, key=lambda k: not unit_of_time(*pairs[k]))), 0 if is_of_time(pairs[0][1]) else None)


def unit_of_time(name: str, unit: str) -> str:
    """The unit of a column of times, perhaps a word of its name, as in time_us or seconds_elapsed; "" for none."""
    return unit or next(filter(is_of_time, re.findall(r"[^\W\d_]+", name)), "")


def is_time_name(name: str) -> bool:
    """Whether a column or channel is called as times are."""
    return _TIME_WORD.search(name) is not None


def is_frequency(name: str, unit: str) -> bool:
    """Whether a column is one of frequencies, by its name or its unit."""
    other = is_of_time(unit) or quantity_of(unit) is not None
    return is_of_frequency(unit) or (not other and _FREQUENCY_WORD.search(name) is not None)


def _are_units(row: Sequence[str]) -> bool:
    found = [normal_unit(cell.strip("[]")) for cell in row]
    known = [not unit or is_unit(unit) for unit in found]
    return all(known) and any(found) and not any(is_number(cell) for cell in row)
