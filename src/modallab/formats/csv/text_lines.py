"""The tables in a text file, as cells: what delimits them, which lines are rows, and what stands above.

One criterion decides each: the delimiter and the number of columns are those whose lines hold numbers most and words
least, over the whole file. A row is a line of as many cells, half of whose columns of numbers hold some or more.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from modallab.core.errors import FormatError
from modallab.formats.csv.csv_cells import BLANKS, DELIMITERS, is_number, plain_numbers, split, with_points
from modallab.formats.unit_text import is_unit, normal_unit

_SHOWN = 300
"""Lines at either end that show the layout of a longer file."""
_BEGINS_A_ROW = re.compile(r"\s*[\"(+\-.,\d]")
_SEPARATOR = re.compile(r"sep=(.)")
_OPEN_QUOTE = re.compile(r'^[^"]*(?:"[^"]*"[^"]*)*(?:^|[,;\t])\s*"[^"]*$')
"""A cell in quotes that does not end in its line."""
_WRAPPED = 16
"""Most lines of such a row."""
_UNIT_BEHIND = re.compile(r"(?<=[\d.])[ \u00a0]+(?P<unit>[^\W\d][^,;|\s\"]*)(?=\s*(?:[,;|\t\"]|$))")
"""A unit in the cell of its number, as MATLAB writes durations: `0.5 sec`."""
_MARK = re.compile(r"^\s*(?:[#%*!]+|//)\s*")
"""What begins a comment."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line and its number in the file, from 1."""

    number: int
    text: str


@dataclass(frozen=True, slots=True)
class TextRow:
    """The cells of a line of numbers, and its number in the file."""

    number: int
    cells: list[str]


@dataclass(frozen=True, slots=True)
class TextTable:
    """One table.

    Attributes:
        above: the lines between it and the table before, without the mark of a comment.
        commented: those of them that have one.
        rows: with decimal points, and without marks between thousands; not all need to have the same cells.
        columns: cells of a row.
        delimiter: of the cells.
        remark: comments that begin with # or %, one after the other.
        ended: whether the last line has its end.
        below: lines of words behind the last row of the file.
        units: by column, that stand behind each of its numbers.
    """

    above: tuple[Line, ...]
    commented: tuple[Line, ...]
    rows: tuple[TextRow, ...]
    columns: int
    delimiter: str
    remark: str
    ended: bool
    below: tuple[Line, ...]
    units: tuple[str, ...]

    def cells_above(self) -> tuple[str, ...]:
        """What stands above it, between any marks; brackets are around a unit, or within one, as in (m/s^2)/N."""
        lines = [line.text for line in (*self.above, *self.commented)]
        return tuple(c for line in lines for mark in (r"[,;:=\t]", r"[,;:=\t\[\]()]") for c in re.split(mark, line))


@dataclass(frozen=True, slots=True)
class _Layout:
    """How lines are cut into cells, and which columns hold numbers."""

    delimiter: str
    columns: int
    numeric: tuple[int, ...]
    weight: float

    def kind(self, cells: Sequence[str]) -> str:
        """Of cells: n those of a row, ? of one that is short, long or has words for numbers, w words."""
        if len(cells) != self.columns:
            return "?" if len(cells) > 1 and all(map(is_number, cells)) else "w"
        held = sum(is_number(cells[k]) for k in self.numeric)
        if 2 * held < len(self.numeric) or not held:
            return "w"
        return "n" if held + sum(not cells[k] for k in self.numeric) == len(self.numeric) else "?"


def read_text(path: Path) -> list[TextTable]:
    """The tables of a text file, which stand below each other; one begins where names stand below numbers.

    Raises:
        FormatError: no text, no table, or marks in numbers that may be of decimals or of thousands.
    """
    text = decoded(path)
    lines = [line for line in _whole_lines(text) if line.text.strip()]
    said = _SEPARATOR.fullmatch(lines[0].text.strip()) if lines else None
    lines, measured = _without_units([_plain(line) for line in (lines[1:] if said else lines)])
    layout = _layout(lines, (said[1],) if said else (*DELIMITERS, BLANKS), str(path))
    cut = [TextRow(line.number, split(line.text, layout.delimiter)) for line in lines]
    kinds = ["#" if _MARK.match(x.text) else layout.kind(row.cells) for x, row in zip(lines, cut, strict=True)]
    remark = "".join(line.text.lstrip() for line in lines if line.text.lstrip().startswith(("#", "%")))
    ended = text.endswith(("\n", "\r"))

    # A last line without its end may be a row that was cut off.
    last = max((k for k, kind in enumerate(kinds, start=1) if kind in "n?"), default=0) if ended else len(kinds)
    below = tuple(lines[last:])
    behind = [_UNIT_BEHIND.search(cell) for cell in split(measured, layout.delimiter)] if measured else []
    units = tuple(found["unit"] if found else "" for found in behind)

    def table(first: int, begin: int, end: int) -> TextTable:
        words, comments = ([_unmarked(lines[k]) for k in range(first, begin) if (kinds[k] == "#") == c] for c in (0, 1))
        rows = [cut[k] for k in range(begin, end) if kinds[k] != "#"]
        plain = _with_points(rows, layout.delimiter, str(path))
        shape = layout.columns, layout.delimiter
        return TextTable(tuple(words), tuple(comments), plain, *shape, remark, ended or end < last, below, units)

    return [table(*span) for span in _spans(cut, kinds[:last], layout.columns)]


def _whole_lines(text: str) -> list[Line]:
    """The lines; a cell in quotes may hold ends of lines, as spreadsheets write wrapped headings."""
    found = [Line(k, line) for k, line in enumerate(text.splitlines(), start=1)]
    for k in [k for k, line in enumerate(found) if line.text.count('"') % 2]:
        if not _OPEN_QUOTE.search(found[k].text):
            continue
        parts = [line.text for line in found[k : k + _WRAPPED]]
        ends = (n for n in range(2, len(parts) + 1) if not sum(part.count('"') for part in parts[:n]) % 2)
        if n := next(ends, 0):
            found[k : k + n] = [Line(found[k].number, " ".join(parts[:n])), *(Line(k, "") for _ in range(1, n))]
    return found


def decoded(path: Path) -> str:
    """The text of a file.

    Raises:
        FormatError: it is none.
    """
    raw = path.read_bytes()
    encodings = ("utf-16",) if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = raw.decode(encoding)
        except UnicodeError:
            continue
        if "\0" not in text:
            return text.replace("\N{MINUS SIGN}", "-")
    raise FormatError("is no text", where=str(path), remedy="name a CSV file, or one of another known kind")


def _plain(line: Line) -> Line:
    return Line(line.number, plain_numbers(line.text)) if _BEGINS_A_ROW.match(line.text) else line


def _without_units(lines: Sequence[Line]) -> tuple[list[Line], str]:
    """The lines without the units that stand behind their numbers, if most have the same ones, and one of them with."""
    said = [tuple(_UNIT_BEHIND.findall(line.text)) for line in lines]
    usual, count = Counter(said).most_common(1)[0] if said else ((), 0)
    if 2 * count <= len(lines) or not usual or not all(is_unit(normal_unit(unit)) for unit in usual):
        return list(lines), ""
    bare = [
        Line(x.number, _UNIT_BEHIND.sub("", x.text)) if own == usual else x for x, own in zip(lines, said, strict=True)
    ]
    return bare, lines[said.index(usual)].text


def _unmarked(line: Line) -> Line:
    return Line(line.number, _MARK.sub("", line.text, count=1))


def _layout(lines: Sequence[Line], marks: Sequence[str], where: str) -> _Layout:
    """The layout whose lines hold numbers most, of several columns if there is one; else the first of the best."""
    shown = lines if len(lines) <= 2 * _SHOWN else [*lines[:_SHOWN], *lines[-_SHOWN:]]
    shown = [line for line in shown if not _MARK.match(line.text)]
    found = max(
        (_of_mark(shown, mark) for mark in marks), key=lambda one: (one.weight > 0 and one.columns > 1, one.weight)
    )
    if found.weight > 0:
        return found
    if not lines:
        raise FormatError(
            "holds no table: it has no lines", where=where, remedy="give a header line and then rows of numbers"
        )
    last = lines[-1]
    begins = f"the last one, line {last.number}, begins with {last.text.strip()[:20]!r}"
    raise FormatError(
        f"holds no table of numbers: its lines hold more words; {begins}",
        where=where,
        remedy="give a header line and then rows of numbers, with the same columns in all",
    )


def _of_mark(lines: Sequence[Line], mark: str) -> _Layout:
    """What the lines are with a delimiter: each counts by its share of numbers, less that of words."""
    held = [[is_number(cell) for cell in split(line.text, mark)] for line in lines]
    empty = [sum(not cell for cell in split(line.text, mark)) for line in lines]
    weights: dict[int, float] = {}
    for numbers, none in zip(held, empty, strict=True):
        if any(numbers):
            share = (2 * sum(numbers) + none - len(numbers)) / (len(numbers) - none)
            weights[len(numbers)] = weights.get(len(numbers), 0.0) + share
    columns, weight = max(weights.items(), key=lambda item: (item[1], item[0]), default=(0, 0.0))
    rows = [numbers for numbers in held if len(numbers) == columns and any(numbers)]
    numeric = tuple(k for k in range(columns) if 2 * sum(numbers[k] for numbers in rows) > len(rows))
    return _Layout(mark, columns, numeric, weight if numeric else 0.0)


def _spans(cut: Sequence[TextRow], kinds: Sequence[str], columns: int) -> list[tuple[int, int, int]]:
    """Of each table the first line above it, its first row, and the line behind it.

    One begins where names stand below numbers, or a line that begins as one above the first table. Lines with words
    for numbers right above the first row are of the table, so that no sample is lost without a word.
    """
    rows = [k for k, kind in enumerate(kinds) if kind == "n"]
    keys = {"".join(cut[i].cells[:1]) for i in range(rows[0] if rows else 0) if kinds[i] == "w"} - {""}
    begins = [0]
    for before, k in pairwise(rows):
        between = [cut[i].cells for i in range(before + 1, k) if kinds[i] == "w"]
        if any((len(cells) == columns and columns > 1) or cells[0] in keys for cells in between if cells):
            begins.append(before + 1)
    spans: list[tuple[int, int, int]] = []
    for above, end in pairwise([*begins, len(kinds)]):
        first = next(k for k in rows if k >= above)
        # One row between lines of fewer words, as of a step for each channel, is a fact.
        while columns > 1 and kinds[first + 1 : first + 2] == ["w"] and len(cut[first + 1].cells) < columns:
            later = next((k for k in rows if first < k < end), None)
            if later is None:
                break
            first = later
        while first > above and kinds[first - 1] == "?":
            first -= 1
        spans.append((above, first, end))
    # One row above names is a fact.
    tables = [span for span in spans if span[2] - span[1] > 1] or spans[-1:]
    return [(0, *tables[0][1:]), *tables[1:]]


def _with_points(rows: Sequence[TextRow], delimiter: str, where: str) -> tuple[TextRow, ...]:
    cells = with_points([row.cells for row in rows], [row.number for row in rows], delimiter, where)
    return tuple(TextRow(row.number, own) for row, own in zip(rows, cells, strict=True))
