"""The table in a CSV file: its delimiter, decimal mark, header, units and numbers."""

import csv
import re
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.unit_text import normal_unit

_DELIMITERS = (";", "\t", ",")
_COMMENT = "#"
_HEADING = re.compile(r"^(?P<name>.*?)\s*(?:[\[(](?P<unit>.*)[\])])?\s*$")


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers.

    Attributes:
        names: heading of each column, () if the file has none.
        units: unit of each column, "" where none is written.
        values: (rows, columns).
        resolution: half of the last digit of the first column.
        ended: whether the last line has its end.
        remark: the comment lines, one after the other.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: NDArray[np.float64]
    resolution: float
    ended: bool
    remark: str = ""


@dataclass(frozen=True)
class _Line:
    number: int
    text: str


def read_table(path: Path) -> Table:
    """Read the table of a CSV file.

    Raises:
        FormatError: no text, no table, or cut off.
    """
    where = str(path)
    text = _decode(path)
    lines = [_Line(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    remark = "".join(line.text.lstrip() for line in lines if line.text.lstrip().startswith(_COMMENT))
    lines = [line for line in lines if not line.text.lstrip().startswith(_COMMENT)]
    delimiter = _delimiter(lines)
    if lines and lines[0].text.startswith("sep="):
        lines = lines[1:]
    heads = _heads(lines, delimiter)
    body = lines[len(heads) :]
    if not body:
        raise FormatError("holds no numbers", where=where, remedy="give a header line and then rows of numbers")
    names, units = _headings(heads, delimiter)
    ended = text.endswith(("\n", "\r"))
    if not ended:
        _check_end(body, delimiter, where)
    values = _numbers(body, delimiter, names, where)
    return Table(names, units, values, _resolution(body, delimiter), ended, remark)


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


def _delimiter(lines: list[_Line]) -> str:
    if lines and re.fullmatch(r"sep=.", lines[0].text.strip()):
        return lines[0].text.strip()[-1]
    # Of those that could be meant, the first: with ; or tab between the columns a comma is a decimal mark.
    sample = [line.text for line in lines[-20:]]
    return next((mark for mark in _DELIMITERS if sample and all(mark in line for line in sample)), ",")


def _fields(line: str, delimiter: str) -> list[str]:
    return [field.strip() for field in next(csv.reader([line], delimiter=delimiter, strict=False), [])]


def _heads(lines: list[_Line], delimiter: str) -> list[_Line]:
    # A line of names, known by its first field; below it perhaps a line of units, in which nothing is a number.
    heads: list[_Line] = []
    if lines and _float(_fields(lines[0].text, delimiter)[0]) is None:
        heads = lines[:1]
        below = [_float(field) for line in lines[1:2] for field in _fields(line.text, delimiter)]
        if below and all(number is None for number in below):
            heads = lines[:2]
    return heads


def _float(field: str) -> float | None:
    try:
        return float(field.replace(",", "."))
    except ValueError:
        return None


def _headings(heads: list[_Line], delimiter: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if not heads:
        return (), ()
    matches = [_HEADING.match(field) for field in _fields(heads[0].text, delimiter)]
    names = tuple(match["name"].strip() if match else "" for match in matches)
    units = tuple(normal_unit(match["unit"] or "") if match else "" for match in matches)
    if len(heads) > 1:  # A second line of words holds units.
        below = [normal_unit(field.strip("[]")) for field in _fields(heads[1].text, delimiter)]
        units = tuple(unit or second for unit, second in zip(units, [*below, *[""] * len(names)], strict=False))
    return names, units


def _check_end(body: list[_Line], delimiter: str, where: str) -> None:
    # Without its line end the last number may have lost digits. It has, if no other of its column has so few after
    # the decimal mark.
    ends = [line.text.rpartition(delimiter)[2].strip() for line in body]
    places = [len(after) if mark else -1 for _, mark, after in (end.replace(",", ".").partition(".") for end in ends)]
    if len(ends) > 1 and places[-1] < min(places[:-1]):
        raise FormatError(
            f"is cut off: line {body[-1].number} ends within a number, {ends[-1]!r}",
            where=where,
            remedy="copy or export the file again",
        )


def _numbers(body: list[_Line], delimiter: str, names: tuple[str, ...], where: str) -> NDArray[np.float64]:
    columns = len(names) or len(_fields(body[0].text, delimiter))
    counts = np.array([line.text.count(delimiter) + 1 for line in body])
    if (counts != columns).any():
        wrong = int((counts != columns).argmax())
        cut = wrong == len(body) - 1
        raise FormatError(
            f"{'is cut off: ' if cut else ''}line {body[wrong].number} has {counts[wrong]} columns, not {columns}",
            where=where,
            remedy="copy or export the file again" if cut else "give every line the same columns",
        )
    decimal_comma = delimiter != ","
    texts = [line.text.replace(",", ".") if decimal_comma else line.text for line in body]
    try:
        return np.loadtxt(texts, delimiter=delimiter, dtype=np.float64, ndmin=2, comments=None, quotechar='"')
    except ValueError as error:
        raise _not_a_number(body, delimiter, names, where) from error


def _not_a_number(body: list[_Line], delimiter: str, names: tuple[str, ...], where: str) -> FormatError:
    for line in body:
        for column, field in enumerate(_fields(line.text, delimiter)):
            if _float(field) is None:
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
    texts = [_fields(line.text, delimiter)[0].replace(",", ".") for line in sample]
    try:
        exponents = [int(Decimal(text).as_tuple().exponent) for text in texts]
    except (InvalidOperation, ValueError):
        return 0.0
    scientific = any("e" in text.lower() for text in texts)
    last = max(exponents) if scientific else min(exponents)
    return 0.5 * 10.0**last if -300 < last < 300 else 0.0
