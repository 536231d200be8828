"""The cells of a line: what delimits them, and numbers as people write them, with their decimal and thousands marks."""

import csv
import re
from collections.abc import Sequence

from modallab.core.errors import FormatError
from modallab.formats.csv.clock_times import is_time

BLANKS = " "
"""The delimiter of columns that any number of blanks separates."""
DELIMITERS = (";", "\t", "|", ",")
_DIGITS = r"(?:\d+(?:[.,]\d+)?|\d+\.|[.,]\d+)(?:[eE][+-]?\d+)?"
_NUMBER = rf"[+-]?{_DIGITS}"
_PAIR = re.compile(rf"\(\s*({_NUMBER})\s*[,;]\s*({_NUMBER})\s*\)")
_ENDS_WITH_UNIT = re.compile(rf"({_NUMBER})\s*([+-])\s*({_DIGITS})\s*\*?\s*[ijIJ](?!\w)")
_BEGINS_WITH_UNIT = re.compile(rf"({_NUMBER})\s*([+-])\s*[ijIJ]\s*\*?\s*({_DIGITS})")
_OLD_EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[+-]\d)")
_ALONE = re.compile(rf"(?<![\w.,+-])({_NUMBER})\s*\*?\s*[ij](?!\w)")
_BELOW_ZERO = re.compile(rf"(?<![\w.])\(({_DIGITS})\)")
"""As accountants write it."""
_LIKE_A_NUMBER = re.compile(
    r"\(?[+-]?[.,]?\d+(?:[.,'’\u00a0\u2009\u202f]\d+)*[.,]?(?: \d{3}(?:[.,]\d+)?)*"
    r"(?:[eE][+-]?\d+)?(?:[+-][\d.,eE+-]+j)?\)?"
)
"""A number with marks of any kind, real or complex."""
_THOUSANDS = re.compile(r"(?<=\d)['’\u00a0\u2009\u202f](?=\d{3}(?!\d))")
"""Marks between digits that stand between thousands and nowhere else."""
_BLANK_THOUSANDS = re.compile(r"(?<=\d) (?=\d{3}(?!\d))")
_BETWEEN = "\t"
_WORDS = re.compile(r'"[^"]*"|\S+')
_POINT_AFTER, _COMMA_AFTER = re.compile(r"\d,\d{3}\.\d"), re.compile(r"\d\.\d{3},\d")
_MARKED = {mark: re.compile(rf"\d+(?:[{mark}]\d+)+(?:[eE][+-]?\d+)?") for mark in ",."}
"""Numbers with a mark, and those of them in which it may stand between thousands."""
_GROUPED = {mark: re.compile(rf"[1-9]\d{{0,2}}(?:[{mark}]\d{{3}})+") for mark in ",."}


def plain_numbers(line: str) -> str:
    """A line with its complex numbers as 1.2+3.4j, whichever of (1.2, 3.4), 1.2 + 3.4i and 1.2+i3.4 they were.

    Exponents of Fortran begin with E.
    """
    if "D" in line or "d" in line:
        line = _OLD_EXPONENT.sub("E", line)
    if "(" in line:
        line = _BELOW_ZERO.sub(r"-\1", line)
        line = _PAIR.sub(lambda m: f"{m[1]}{m[2] if m[2][0] in '+-' else '+' + m[2]}j", line)
    if "i" in line or "j" in line or "I" in line or "J" in line:
        line = _ENDS_WITH_UNIT.sub(r"\1\2\3j", line)
        line = _BEGINS_WITH_UNIT.sub(r"\1\2\3j", line)
        line = _ALONE.sub(r"0+\1j", line).replace("0++", "0+").replace("0+-", "0-")
    return re.sub(r"\(([^(),;\s]+j)\)", r"\1", line) if "(" in line else line


def split(line: str, delimiter: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them.

    Raises:
        FormatError: a cell is longer than any number or name.
    """
    if delimiter == BLANKS:
        return [cell.strip('"') for cell in _WORDS.findall(line)] if '"' in line else line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        found = next(csv.reader([line], delimiter=delimiter, strict=False, skipinitialspace=True), [])
        return [cell.strip() for cell in found]
    except csv.Error as error:
        what = f"is no table: a line of {len(line)} characters begins {line[:20]!r}"
        raise FormatError(what, remedy="name a file with one row of numbers a line") from error


def head_cells(line: str, delimiter: str, columns: int) -> list[str]:
    """The cells of a line of names, in which a single blank may belong to a name."""
    found = split(line, delimiter)
    if delimiter == BLANKS and len(found) != columns:
        return [cell.strip() for cell in re.split(r"\s{2,}|\t", line.strip())]
    return found


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with marks of any kind, or a time."""
    try:
        float(cell)
    except ValueError:
        return _LIKE_A_NUMBER.fullmatch(cell) is not None or is_time(cell)
    return True


def number(cell: str) -> float | None:
    """A real number with a decimal point or comma; None if the cell holds none."""
    try:
        return float(cell.replace(",", "."))
    except ValueError:
        return None


def complex_number(cell: str) -> complex | None:
    """A real or complex number; None if the cell holds none."""
    try:
        return complex(cell)
    except ValueError:
        return None


def with_points(rows: Sequence[Sequence[str]], numbers: Sequence[int], delimiter: str, where: str) -> list[list[str]]:
    """Cells with decimal points and without marks between thousands; times stay as they are.

    Args:
        rows: of cells.
        numbers: of their lines, for the message.
        delimiter: of the cells.
        where: the file, for the message.

    Raises:
        FormatError: a mark may be either.
    """
    kept = [k for k, cell in enumerate(rows[0]) if is_time(cell)] if rows else []
    text = "\n".join(_BETWEEN.join("" if k in kept else cell for k, cell in enumerate(row)) for row in rows)
    if not text.isascii() or "'" in text:
        text = _THOUSANDS.sub("", text)
    if delimiter != BLANKS and " " in text:
        text = _BLANK_THOUSANDS.sub("", text)
    if "," in text:
        group = _group_mark(text, numbers, where)
        text = (text.replace(group, "") if group else text).replace(",", ".")
    found = [line.split(_BETWEEN) for line in text.split("\n")] if rows else []
    for own, row in zip(found, rows, strict=True):
        for k in kept:
            if k < len(row):
                own[k] = row[k]
    return found


def _group_mark(text: str, numbers: Sequence[int], where: str) -> str:
    """The mark that stands between thousands, "" if there is none."""
    for pattern, mark in ((_POINT_AFTER, ","), (_COMMA_AFTER, ".")):
        if pattern.search(text):
            return mark
    for mark, other in ((",", "."), (".", ",")):
        found = list(_MARKED[mark].finditer(text))
        grouped = found and all(_GROUPED[mark].fullmatch(one[0]) for one in found)
        if grouped and any(not _GROUPED[other].fullmatch(cell) for cell in _MARKED[other].findall(text)):
            line = numbers[text.count("\n", 0, found[0].start())]
            what = f"line {line}: {found[0][0]!r} beside numbers with decimal {other!r} may be in thousands"
            raise FormatError(what, where=where, remedy="export the file with one decimal mark, and without thousands")
    return ""
