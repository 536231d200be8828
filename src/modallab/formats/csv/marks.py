"""Marks in numbers: decimal commas, and marks between thousands, as the cells of a whole table show them."""

import re
from collections.abc import Sequence

from modallab.core.errors import FormatError
from modallab.formats.csv.clock_times import is_time
from modallab.formats.csv.csv_cells import BLANKS

_THOUSANDS = re.compile(r"(?<=\d)['’\u00a0\u2009\u202f](?=\d{3}(?!\d))")
"""Marks between digits that stand between thousands and nowhere else."""
_BLANK_THOUSANDS = re.compile(r"(?<=\d) (?=\d{3}(?!\d))")
_BETWEEN = "\t"
_POINT_AFTER, _COMMA_AFTER = re.compile(r"\d,\d{3}\.\d"), re.compile(r"\d\.\d{3},\d")
_MARKED = {mark: re.compile(rf"\d+(?:[{mark}]\d+)+(?:[eE][+-]?\d+)?") for mark in ",."}
"""Numbers with a mark, and those of them in which it may stand between thousands."""
_GROUPED = {mark: re.compile(rf"[1-9]\d{{0,2}}(?:[{mark}]\d{{3}})+") for mark in ",."}


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
