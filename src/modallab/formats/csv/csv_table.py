"""The table in a text file: names and units of its columns, and their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.errors import FormatError
from modallab.formats.csv.clock_times import is_date, is_time, seconds_of
from modallab.formats.csv.csv_cells import complex_number, head_cells, is_number, split
from modallab.formats.csv.csv_facts import Facts, counts_rows, facts_of, names_by_facts
from modallab.formats.csv.csv_heads import BY_OPTION, abscissa, headings, parse_headings
from modallab.formats.csv.digits import half_last_digits
from modallab.formats.csv.text_lines import Line, TextRow, TextTable, read_text
from modallab.formats.unit_text import normal_unit


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers.

    Attributes:
        names: heading of each column, () if the file has none.
        units: unit of each column, "" where none is written.
        values: (rows, columns), the real part of complex numbers; NaN in columns that hold something else.
        resolution: (rows,) half of the last digit of the first column.
        ended: whether the last line has its end.
        remark: the comment lines, one after the other.
        imaginary: (rows, columns), 0 in columns of real numbers; None if there are no complex ones.
        no_numbers: by column, what stands there instead of a number.
        facts: what stands above it.
        note: on lines that were left out.
        elsewhere: what stands above a table without units, cell by cell: units may be among them.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Real
    resolution: Real
    ended: bool
    remark: str = ""
    imaginary: Real | None = None
    no_numbers: Mapping[int, FormatError] = field(default_factory=dict[int, FormatError])
    facts: Facts = field(default_factory=Facts)
    note: str = ""
    elsewhere: tuple[str, ...] = ()

    def require(self, columns: Sequence[int]) -> None:
        """Reject columns that hold something else than numbers.

        Raises:
            FormatError: names the line and what stands there.
        """
        for column in columns:
            if column in self.no_numbers:
                raise self.no_numbers[column]


def read_table(path: Path) -> Table:
    """Read the first table of a text file.

    Raises:
        FormatError: no text, no table, or cut off.
    """
    return _table(read_text(path)[0], str(path))


def read_tables(path: Path, said: str = "") -> list[Table]:
    """Read all tables of a text file, which stand below each other.

    Args:
        path: of the file.
        said: names and units of the columns as the user says them; "" for those of the header.

    Raises:
        FormatError: as `read_table`.
        DataError: the user names more or fewer columns than there are.
    """
    return [_table(text, str(path), said) for text in read_text(path)]


@dataclass(frozen=True, slots=True)
class _Column:
    """A column as it stands in the file; `place` counts from 1."""

    place: int
    name: str
    unit: str
    cells: Sequence[str]


def _table(text: TextTable, where: str, said: str = "") -> Table:
    text = text if said else _without_repeats(text)
    facts = facts_of(_texts(text.above), text.delimiter)
    columns, names = _columns(text, facts, where, said)
    if not text.ended:
        _check_end(text, where)
    numbers = [_numbers(column, text.rows, where) for column in columns]
    others = {k: one for k, one in enumerate(numbers) if isinstance(one, FormatError)}
    if others and (0 in others or not names):
        raise others[min(others)]
    values = np.column_stack([np.full(len(text.rows), np.nan) if isinstance(n, FormatError) else n for n in numbers])
    real = np.ascontiguousarray(values.real)
    return Table(
        tuple(column.name for column in columns) if names else (),
        tuple(column.unit for column in columns) if names else (),
        real,
        half_last_digits(columns[0].cells, real[:, 0]),
        text.ended,
        text.remark,
        np.ascontiguousarray(values.imag) if np.iscomplexobj(values) else None,
        others,
        facts,
        _note(text.below),
        () if any(column.unit for column in columns[1:]) else text.cells_above(),
    )


def _note(below: Sequence[Line]) -> str:
    if not below:
        return ""
    return f"left out is what stands below the table, from line {below[0].number}, {below[0].text.strip()[:40]!r}"


def _without_repeats(text: TextTable) -> TextTable:
    """The table without the columns that repeat the first in every row, as where each channel has its own times."""
    first = [row.cells[0] for row in text.rows]
    kept = [
        k for k in range(text.columns) if not k or [row.cells[k : k + 1] for row in text.rows] != [[c] for c in first]
    ]
    if len(kept) == text.columns:
        return text
    rows = tuple(TextRow(row.number, [row.cells[k] for k in kept if k < len(row.cells)]) for row in text.rows)

    def cut(line: Line) -> Line:
        cells = head_cells(line.text, text.delimiter, text.columns)
        whole = [cells[k] for k in kept] if len(cells) == text.columns else cells
        return Line(line.number, text.delimiter.join(f'"{c}"' if text.delimiter in c else c for c in whole))

    return replace(
        text,
        above=tuple(map(cut, text.above)),
        rows=rows,
        columns=len(kept),
        units=tuple(text.units[k] for k in kept if text.units),
    )


def _columns(text: TextTable, facts: Facts, where: str, said: str) -> tuple[list[_Column], bool]:
    """The columns that have a name, the abscissa first, and whether they have names.

    Without names those that hold something, in their order.
    """
    cells = _by_column(text, where)
    filled = max((k for k, own in enumerate(cells, start=1) if any(own)), default=1)
    if said:
        names, units = parse_headings(said, len(cells), filled, where)
    else:
        lines = _texts(text.above), _texts(text.commented)
        names, units = headings(*lines, text.delimiter, len(cells), filled, facts)
        names, units = (names, units) if names else names_by_facts(facts, cells)
        if not names and len(cells) > 2 and counts_rows(cells[0]):
            names, units = headings(*lines, text.delimiter, len(cells) - 1, filled - 1, facts)
            names, units = (("", *names), ("", *units)) if names else ((), ())
        if not names and len(cells) > len(text.rows):
            raise _transposed(text, where)
        if not names and text.above:
            raise _no_names(text, len(cells), where)
    blank = ("",) * len(cells)
    behind = (*map(normal_unit, text.units), *blank)
    units = [unit or own for unit, own in zip(units or blank, behind, strict=False)]
    found = [_Column(k, *one) for k, one in enumerate(zip(names or blank, units, cells, strict=True), start=1)]
    found = _with_seconds(found, named=bool(names))
    found = [column for column in found if column.name or (not names and any(column.cells))]
    first = abscissa([c.name for c in found], [c.unit for c in found]) or 0
    return [found[first], *found[:first], *found[first + 1 :]], bool(names)


def _texts(lines: Sequence[Line]) -> list[str]:
    return [line.text for line in lines]


def _by_column(text: TextTable, where: str) -> list[Sequence[str]]:
    """The cells of each column. Where a line above names as many columns as the longest row has, others end early."""
    counts = np.array([len(row.cells) for row in text.rows])
    columns = int(counts.max())
    if (counts != text.columns).any():
        named = any(len(head_cells(line.text, text.delimiter, columns)) == columns for line in text.above)
        if not named or (counts[:-1] == columns).all():
            raise _other_columns(text, counts, where)
    return list(zip(*([*row.cells, *[""] * (columns - len(row.cells))] for row in text.rows), strict=True))


def _with_seconds(columns: Sequence[_Column], *, named: bool) -> list[_Column]:
    """With seconds, called time, where a column holds clock times, and a column of dates before it is left out."""
    found: list[_Column] = []
    for column in columns:
        if not is_time(column.cells[0]) or is_date(column.cells[0]):
            found.append(column)
            continue
        moments = column.cells
        if found and is_date(found[-1].cells[0]):
            moments = [f"{day} {clock}" for day, clock in zip(found.pop().cells, moments, strict=True)]
        found.append(replace(column, name="time" if named else "", unit="s", cells=seconds_of(moments)))
    return found


def _check_end(text: TextTable, where: str) -> None:
    # Without its line end the last number may have lost digits. It has, if no other of its column has so few after
    # the decimal mark.
    ends = [row.cells[-1] for row in text.rows]
    places = [len(after) if mark else -1 for _, mark, after in (end.partition(".") for end in ends)]
    if len(ends) > 1 and places[-1] < min(places[:-1]):
        raise FormatError(
            f"is cut off: line {text.rows[-1].number} ends within a number, {ends[-1]!r}",
            where=where,
            remedy="copy or export the file again",
        )


def _numbers(column: _Column, rows: Sequence[TextRow], where: str) -> Real | NDArray[np.complex128] | FormatError:
    """The numbers of a column, or what stands there instead of one."""
    for kind in (float, complex):
        try:
            return np.array([kind(cell) for cell in column.cells])
        except ValueError:
            pass
    wrong = next(k for k, cell in enumerate(column.cells) if complex_number(cell) is None)
    cell, name = column.cells[wrong], f" ({column.name})" if column.name else ""
    found = f"{cell!r} is no number" if cell else "is empty"
    option = f", or leave the column out with --ignore {column.name!r}" if column.name and column.place > 1 else ""
    return FormatError(
        f"line {rows[wrong].number}, column {column.place}{name}: {found}",
        where=where,
        remedy=f"export the file again, with numbers only below the header{option}",
    )


def _no_names(text: TextTable, columns: int, where: str) -> FormatError:
    last, first = text.above[-1], text.rows[0].number
    if text.delimiter == "," and columns > 2 and any(2 * len(split(line.text, ",")) == columns for line in text.above):
        return FormatError(
            f"line {first} has {columns} cells for {columns // 2} columns: commas stand between the columns and as "
            "decimal marks",
            where=where,
            remedy="export it with decimal points, or with ; or tabs between the columns",
        )
    return FormatError(
        f"line {first} has {columns} columns, and no line above it names as many: the last one, line {last.number}, is "
        f"{last.text.strip()[:40]!r}",
        where=where,
        remedy=BY_OPTION,
    )


def _transposed(text: TextTable, where: str) -> FormatError:
    return FormatError(
        f"has {len(text.rows)} rows of {text.columns} cells and no names above them: it looks transposed",
        where=where,
        remedy="export one column for each channel, and one row for each sample",
    )


def _other_columns(text: TextTable, counts: NDArray[np.int64], where: str) -> FormatError:
    wrong = int((counts != text.columns).argmax())
    row = text.rows[wrong]
    cut = wrong == len(text.rows) - 1 and (not text.ended or is_number(row.cells[0]))
    shown = " ".join(row.cells)[:40]
    found = f"line {row.number} has {counts[wrong]} columns, not {text.columns}: {shown!r}"
    return FormatError(
        f"is cut off: {found}" if cut else found,
        where=where,
        remedy="copy or export the file again" if cut else "give every line the same columns, and nothing below them",
    )
