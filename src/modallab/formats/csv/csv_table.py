"""The table in a text file: names and units of its columns, and their numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, FormatError
from modallab.formats.csv.csv_cells import BLANKS, cells, complex_number, n_cells
from modallab.formats.csv.csv_heads import BY_OPTION, Heads, headings, said_headings
from modallab.formats.csv.digits import half_last_digits
from modallab.formats.csv.text_lines import Line, TextLines, read_lines

Real = NDArray[np.float64]

_TITLE = re.compile(r"^(?:(?:FRF|transfer function|frequency response(?: function)?|H[12v])\b[\s:(]*)+", re.IGNORECASE)
"""What stands before the response in the title of a table of FRFs."""


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
        title: the last line of a single cell above it.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Real
    resolution: Real
    ended: bool
    remark: str = ""
    imaginary: Real | None = None
    no_numbers: Mapping[int, FormatError] = field(default_factory=dict[int, FormatError])
    title: str = ""

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
    return _table(read_lines(path)[0], str(path))


def read_tables(path: Path, said: str = "") -> list[Table]:
    """Read all tables of a text file, which stand below each other.

    Args:
        path: of the file.
        said: names and units of the columns as the user says them; "" for those of the header.

    Raises:
        FormatError: as `read_table`.
        DataError: the user names more or fewer columns than there are.
    """
    return [_table(lines, str(path), said) for lines in read_lines(path)]


def _table(lines: TextLines, where: str, said: str = "") -> Table:
    columns = n_cells(lines.body[-1 if len(lines.body) == 1 else -2].text, lines.delimiter)
    names, units = said_headings(said, columns, where) if said else _headings(lines, columns)
    if lines.delimiter == BLANKS and lines.above and not names:
        first = lines.above[0]
        raise _not_a_number(first, 0, cells(first.text, BLANKS)[0], (), where)
    if lines.clock and names:
        names, units = ("time", *names[1:]), ("s", *units[1:])
    if not lines.ended:
        _check_end(lines, where)
    values, others = _numbers(lines, names, where)
    imaginary = np.ascontiguousarray(values.imag) if np.iscomplexobj(values) else None
    real = np.ascontiguousarray(values.real)
    texts = [cells(line.text, lines.delimiter)[0].replace(",", ".") for line in lines.body]
    resolution = half_last_digits(texts, real[:, 0])
    titles = [
        text for text in (line.text.strip().strip('"') for line in lines.above) if n_cells(text, lines.delimiter) == 1
    ]
    remark, title = "".join(lines.comments), titles[-1] if titles else ""
    return Table(names, units, real, resolution, lines.ended, remark, imaginary, others, title)


def _headings(lines: TextLines, columns: int) -> Heads:
    marked = [comment.lstrip("#%").strip() for comment in lines.comments]
    return headings([line.text for line in lines.above], marked, lines.delimiter, columns)


def side_by_side(tables: Sequence[Table], where: str) -> Table:
    """Tables of FRFs below each other as one. Columns that are called alike in two take their table's title.

    Raises:
        DataError: the tables differ in their first column, or columns called alike have no titles.
    """
    first = tables[0]
    if len(tables) == 1:
        return first
    _require_lines(tables, where)
    parts = [t.values if t.imaginary is None else t.values + 1j * t.imaginary for t in tables]
    whole = np.hstack([first.values[:, :1], *(part[:, 1:] for part in parts)])
    return replace(
        first,
        names=(first.names[0], *_names_of_all(tables, where)),
        units=(first.units[0], *(unit for table in tables for unit in table.units[1:])),
        values=np.ascontiguousarray(whole.real),
        ended=tables[-1].ended,
        imaginary=np.ascontiguousarray(whole.imag) if np.iscomplexobj(whole) else None,
    )


def _require_lines(tables: Sequence[Table], where: str) -> None:
    first = tables[0]
    for k, table in enumerate(tables, start=1):
        if not np.array_equal(table.values[:, 0], first.values[:, 0]):
            raise DataError(
                f"table {k} of {len(tables)} has other frequencies than the first: {_span(table)}, not {_span(first)}",
                where=where,
                remedy="export FRFs at the same lines, or each to a file of its own",
            )


def _names_of_all(tables: Sequence[Table], where: str) -> list[str]:
    names = [name for table in tables for name in table.names[1:]]
    if len(set(names)) == len(names):
        return names
    titles = [_TITLE.sub("", table.title).rstrip(") ").replace(",", "/") for table in tables]
    if "" in titles or len(set(titles)) < len(titles):
        raise DataError(
            f"holds {len(tables)} tables of FRFs below each other, and not the response of each",
            where=where,
            remedy="write the response above each table, as FRF a1/force, or give one table with a column for each",
        )
    return [f"{name} {title}" for table, title in zip(tables, titles, strict=True) for name in table.names[1:]]


def _span(table: Table) -> str:
    return f"{len(table.values)} from {table.values[0, 0]:g} to {table.values[-1, 0]:g}"


def _check_end(lines: TextLines, where: str) -> None:
    # Without its line end the last number may have lost digits. It has, if no other of its column has so few after
    # the decimal mark.
    ends = [cells(line.text, lines.delimiter)[-1] for line in lines.body]
    places = [len(after) if mark else -1 for _, mark, after in (end.replace(",", ".").partition(".") for end in ends)]
    if len(ends) > 1 and places[-1] < min(places[:-1]):
        raise FormatError(
            f"is cut off: line {lines.body[-1].number} ends within a number, {ends[-1]!r}",
            where=where,
            remedy="copy or export the file again",
        )


def _numbers(
    lines: TextLines, names: tuple[str, ...], where: str
) -> tuple[Real | NDArray[np.complex128], dict[int, FormatError]]:
    body, delimiter = lines.body, lines.delimiter
    columns = len(names) or n_cells(body[0].text, delimiter)
    counts = np.array([n_cells(line.text, delimiter) for line in body])
    if (counts != columns).any():
        raise _other_columns(lines, counts, columns, where)
    if not any("j" in line.text for line in body):
        texts = [line.text if delimiter == "," else line.text.replace(",", ".") for line in body]
        split = None if delimiter == BLANKS else delimiter
        try:
            return np.loadtxt(texts, delimiter=split, dtype=np.float64, ndmin=2, comments=None, quotechar='"'), {}
        except ValueError:
            pass
    return _cell_by_cell(body, delimiter, names, where)


def _cell_by_cell(
    body: Sequence[Line], delimiter: str, names: Sequence[str], where: str
) -> tuple[Real | NDArray[np.complex128], dict[int, FormatError]]:
    rows = [cells(line.text, delimiter) for line in body]
    found = [[complex_number(cell) for cell in row] for row in rows]
    others: dict[int, FormatError] = {}
    for line, row, values in zip(body, rows, found, strict=True):
        for k, value in enumerate(values):
            if value is None and k not in others:
                others[k] = _not_a_number(line, k, row[k], names, where)
    if 0 in others or (others and not names):
        raise next(iter(others.values()))
    numbers = np.array([[np.nan if value is None else value for value in row] for row in found], np.complex128)
    return (numbers if any("j" in line.text for line in body) else numbers.real), others


def _other_columns(lines: TextLines, counts: NDArray[np.int64], columns: int, where: str) -> FormatError:
    body = lines.body
    wrong = int((counts != columns).argmax())
    if lines.delimiter == "," and (counts == 2 * columns).all():
        return FormatError(
            f"line {body[wrong].number} has {counts[wrong]} cells for {columns} columns: commas stand between the "
            "columns and as decimal marks",
            where=where,
            remedy="export it with decimal points, or with ; or tabs between the columns",
        )
    if len(set(counts.tolist())) == 1 and lines.above:
        return FormatError(
            f"line {body[0].number} has {counts[0]} columns, and no line above it names as many: the last one, line "
            f"{lines.above[-1].number}, is {lines.above[-1].text.strip()[:40]!r}",
            where=where,
            remedy=BY_OPTION,
        )
    cut = wrong == len(body) - 1
    found = f"line {body[wrong].number} has {counts[wrong]} columns, not {columns}: {body[wrong].text.strip()[:40]!r}"
    return FormatError(
        f"is cut off: {found}" if cut else found,
        where=where,
        remedy="copy or export the file again" if cut else "give every line the same columns",
    )


def _not_a_number(line: Line, column: int, cell: str, names: Sequence[str], where: str) -> FormatError:
    name = f" ({names[column]})" if column < len(names) else ""
    found = f"{cell!r} is no number" if cell else "is empty"
    option = f", or leave the column out with --ignore {names[column]!r}" if column < len(names) and column else ""
    return FormatError(
        f"line {line.number}, column {column + 1}{name}: {found}",
        where=where,
        remedy=f"export the file again, with numbers only below the header{option}",
    )
