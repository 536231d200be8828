"""The table in a text file: its delimiter, decimal mark, header, units and numbers."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.csv.csv_cells import BLANKS, cells, complex_number, delimiter_of, n_cells, number, plain_complex
from modallab.formats.csv.csv_heads import headings

_COMMENTS = ("#", "%")


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers.

    Attributes:
        names: heading of each column, () if the file has none.
        units: unit of each column, "" where none is written.
        values: (rows, columns), the real part of complex numbers.
        resolution: half of the last digit of the first column.
        ended: whether the last line has its end.
        remark: the comment lines, one after the other.
        imaginary: (rows, columns), 0 in columns of real numbers; None if there are no complex ones.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: NDArray[np.float64]
    resolution: float
    ended: bool
    remark: str = ""
    imaginary: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class _Line:
    number: int
    text: str


def read_table(path: Path) -> Table:
    """Read the table of a text file.

    Raises:
        FormatError: no text, no table, or cut off.
    """
    where = str(path)
    text = _decode(path)
    lines = [_Line(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    comments = [line.text.lstrip() for line in lines if line.text.lstrip().startswith(_COMMENTS)]
    lines = [line for line in lines if not line.text.lstrip().startswith(_COMMENTS)]
    delimiter, lines = _delimited(lines)
    above = next((k for k, line in enumerate(lines) if _begins_with_number(line, delimiter)), len(lines))
    body = [_Line(line.number, plain_complex(line.text)) for line in lines[above:]]
    if not body:
        raise FormatError("holds no numbers", where=where, remedy="give a header line and then rows of numbers")
    columns = n_cells(body[-1].text if len(body) == 1 else body[-2].text, delimiter)
    marked = [comment.lstrip("".join(_COMMENTS)).strip() for comment in comments]
    names, units = headings([line.text for line in lines[:above]], marked, delimiter, columns)
    if delimiter == BLANKS and above and not names:
        raise _not_a_number([_Line(lines[0].number, lines[0].text)], delimiter, (), where)
    ended = text.endswith(("\n", "\r"))
    if not ended:
        _check_end(body, delimiter, where)
    values = _numbers(body, delimiter, names, where)
    imaginary = np.ascontiguousarray(values.imag) if np.iscomplexobj(values) else None
    real = np.ascontiguousarray(values.real)
    return Table(names, units, real, _resolution(body, delimiter), ended, "".join(comments), imaginary)


def _decode(path: Path) -> str:
    raw = path.read_bytes()
    encodings = ("utf-16",) if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = raw.decode(encoding)
        except UnicodeError:
            continue
        if "\0" not in text:
            return text
    raise FormatError("is no text", where=str(path), remedy="name a CSV file, or one of another known kind")


def _delimited(lines: list[_Line]) -> tuple[str, list[_Line]]:
    """The delimiter, and the lines without the one that may say it."""
    if lines and (said := re.fullmatch(r"sep=(.)", lines[0].text.strip())):
        return said[1], lines[1:]
    return delimiter_of([plain_complex(line.text) for line in lines[-20:]]), lines


def _begins_with_number(line: _Line, delimiter: str) -> bool:
    return number((cells(plain_complex(line.text), delimiter) or [""])[0]) is not None


def _check_end(body: list[_Line], delimiter: str, where: str) -> None:
    # Without its line end the last number may have lost digits. It has, if no other of its column has so few after
    # the decimal mark.
    ends = [cells(line.text, delimiter)[-1] for line in body]
    places = [len(after) if mark else -1 for _, mark, after in (end.replace(",", ".").partition(".") for end in ends)]
    if len(ends) > 1 and places[-1] < min(places[:-1]):
        raise FormatError(
            f"is cut off: line {body[-1].number} ends within a number, {ends[-1]!r}",
            where=where,
            remedy="copy or export the file again",
        )


def _numbers(
    body: list[_Line], delimiter: str, names: tuple[str, ...], where: str
) -> NDArray[np.float64] | NDArray[np.complex128]:
    columns = len(names) or n_cells(body[0].text, delimiter)
    counts = np.array([n_cells(line.text, delimiter) for line in body])
    if (counts != columns).any():
        wrong = int((counts != columns).argmax())
        cut = wrong == len(body) - 1
        raise FormatError(
            f"{'is cut off: ' if cut else ''}line {body[wrong].number} has {counts[wrong]} columns, not {columns}",
            where=where,
            remedy="copy or export the file again" if cut else "give every line the same columns",
        )
    if any("j" in line.text for line in body):
        rows = [[complex_number(cell) for cell in cells(line.text, delimiter)] for line in body]
        return np.array([[_there(cell, body, delimiter, names, where) for cell in row] for row in rows], np.complex128)
    texts = [line.text if delimiter == "," else line.text.replace(",", ".") for line in body]
    split = None if delimiter == BLANKS else delimiter
    try:
        return np.loadtxt(texts, delimiter=split, dtype=np.float64, ndmin=2, comments=None, quotechar='"')
    except ValueError as error:
        raise _not_a_number(body, delimiter, names, where) from error


def _there(cell: complex | None, body: list[_Line], delimiter: str, names: tuple[str, ...], where: str) -> complex:
    if cell is None:
        raise _not_a_number(body, delimiter, names, where)
    return cell


def _not_a_number(body: list[_Line], delimiter: str, names: Sequence[str], where: str) -> FormatError:
    for line in body:
        for column, field in enumerate(cells(line.text, delimiter)):
            if complex_number(field) is None:
                name = f" ({names[column]})" if column < len(names) else ""
                return FormatError(
                    f"line {line.number}, column {column + 1}{name}: {field!r} is no number",
                    where=where,
                    remedy="export the file again, with numbers only below the header",
                )
    return FormatError("holds something that is no number", where=where, remedy="export the file again")


def _resolution(body: list[_Line], delimiter: str) -> float:
    """Half of the last digit in the first column: the finest of plain numbers, the coarsest of those with exponents."""
    sample = [*body[:: max(1, len(body) // 50)], body[-1]]
    texts = [cells(line.text, delimiter)[0].replace(",", ".") for line in sample]
    try:
        exponents = [int(Decimal(text).as_tuple().exponent) for text in texts]
    except (InvalidOperation, ValueError):
        return 0.0
    scientific = any("e" in text.lower() for text in texts)
    last = max(exponents) if scientific else min(exponents)
    return 0.5 * 10.0**last if -300 < last < 300 else 0.0
