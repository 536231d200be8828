"""The lines of a text file, brought to one form: one delimiter, no quotes, and times in seconds."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from modallab.core.errors import FormatError
from modallab.formats.csv.clock_times import is_clock, is_date, seconds_of
from modallab.formats.csv.csv_cells import BLANKS, cells, delimiter_of, number, plain_numbers

_COMMENTS = ("#", "%")
_SHOWN = 20
"""Lines at the end that show what delimits the columns."""
_QUOTED = re.compile(r'"[^"]*"')
_THOUSANDS = re.compile(r"(?<=\d)['’\u00a0\u2009\u202f](?=\d{3}(?!\d))")
"""Marks between digits that stand between thousands and nowhere else."""
_BLANK_THOUSANDS = re.compile(r"(?<=\d) (?=\d{3}(?!\d))")
_POINT_AFTER, _COMMA_AFTER = re.compile(r"\d,\d{3}\.\d"), re.compile(r"\d\.\d{3},\d")

_MARKED = {mark: re.compile(rf"\d+(?:[{mark}]\d+)+(?:[eE][+-]?\d+)?") for mark in ",."}
"""Numbers with a mark, and those of them in which it may stand between thousands."""
_GROUPED = {mark: re.compile(rf"[1-9]\d{{0,2}}(?:[{mark}]\d{{3}})+") for mark in ",."}


@dataclass(frozen=True, slots=True)
class Line:
    """A line and its number in the file, from 1."""

    number: int
    text: str


@dataclass(frozen=True, slots=True)
class TextLines:
    """A file's lines.

    Attributes:
        above: those before the numbers.
        body: those with numbers.
        comments: those with the mark of a comment, without blanks before it.
        delimiter: of the columns of `above` and `body`.
        ended: whether the last line has its end.
        clock: whether the first column held clock times, which are seconds now.
    """

    above: tuple[Line, ...]
    body: tuple[Line, ...]
    comments: tuple[str, ...]
    delimiter: str
    ended: bool
    clock: bool = False


def read_lines(path: Path) -> list[TextLines]:
    """The lines of a text file, of each of its tables: one begins where a line of names stands below numbers.

    Raises:
        FormatError: no text, or no numbers.
    """
    text = _THOUSANDS.sub("", decoded(path))
    lines = [Line(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    comments = tuple(line.text.lstrip() for line in lines if line.text.lstrip().startswith(_COMMENTS))
    lines = [line for line in lines if not line.text.lstrip().startswith(_COMMENTS)]
    delimiter, lines = _delimited(lines)
    if delimiter != BLANKS:
        lines = [replace(line, text=_BLANK_THOUSANDS.sub("", line.text)) for line in lines]
    parts = _tables(lines, delimiter)
    ended = [True] * (len(parts) - 1) + [text.endswith(("\n", "\r"))]
    return [_table(part, delimiter, comments, end, str(path)) for part, end in zip(parts, ended, strict=True)]


def _table(lines: Sequence[Line], delimiter: str, comments: tuple[str, ...], ended: bool, where: str) -> TextLines:
    first = _first_row(lines, delimiter)
    if first is None:
        raise _no_numbers(lines, delimiter, where)
    body = [replace(line, text=plain_numbers(line.text)) for line in lines[first:]]
    found = TextLines(tuple(lines[:first]), tuple(body), comments, delimiter, ended)
    return _without_groups(_with_seconds(_without_end(found)), where)


def _tables(lines: Sequence[Line], delimiter: str) -> list[Sequence[Line]]:
    """The lines of each table: those between two are of the second, if one of them names all its columns."""
    first = _first_row(lines, delimiter) or 0
    columns = len(cells(lines[first].text, delimiter)) if lines else 0
    begins, words = [0], -1
    for k in range(first, len(lines)):
        if not _begins(lines[k], delimiter):
            words = k if words < 0 else words
        elif words >= 0:
            named = any(len(cells(line.text, delimiter)) == columns for line in lines[words:k])
            begins += [words] if named and columns > 1 else []
            words = -1
    return [lines[a:b] for a, b in zip(begins, [*begins[1:], len(lines)], strict=True)]


def decoded(path: Path) -> str:
    """The text of a file.

    Raises:
        FormatError: it is none.
    """
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


def _delimited(lines: list[Line]) -> tuple[str, list[Line]]:
    """The delimiter, and the lines without the one that may say it, and without quotes."""
    separator = re.fullmatch(r"sep=(.)", lines[0].text.strip()) if lines else None
    lines = lines[1:] if separator else lines
    shown = [_QUOTED.sub('""', plain_numbers(line.text)) for line in lines[-_SHOWN:]]
    delimiter = separator[1] if separator else delimiter_of(shown)
    if delimiter == "\t" or not any('""' in line for line in shown):
        return delimiter, lines
    # Within quotes a comma may be a decimal mark.
    return "\t", [replace(line, text="\t".join(cells(line.text, delimiter))) for line in lines]


def _first_row(lines: Sequence[Line], delimiter: str) -> int | None:
    """The place of the first row of the table; None if no line begins with a number.

    Facts above a table may begin with a number too. They have other columns than the last rows, and words stand
    between them and the table.
    """
    last = [line for line in lines[-_SHOWN:] if _begins(line, delimiter)][-2:]
    columns = len(cells(last[0].text, delimiter)) if last else 0
    begins: list[int] = []
    for k, line in enumerate(lines):
        if not _begins(line, delimiter):
            begins = []
            continue
        begins.append(k)
        if not last or len(cells(line.text, delimiter)) == columns:
            return begins[0]
    return None


def _begins(line: Line, delimiter: str) -> bool:
    row = cells(plain_numbers(line.text), delimiter)
    first = row[0] if row else ""
    return number(first) is not None or is_clock(first) or (is_date(first) and len(row) > 1 and is_clock(row[1]))


def _no_numbers(lines: Sequence[Line], delimiter: str, where: str) -> FormatError:
    if not lines:
        return FormatError("holds no numbers", where=where, remedy="give a header line and then rows of numbers")
    last = lines[-1]
    first = (cells(last.text, delimiter) or [""])[0]
    begins = f"the last one, line {last.number}, begins with {first[:20]!r}"
    return FormatError(
        f"holds no numbers: no line begins with a number or a time; {begins}",
        where=where,
        remedy="give a header line and then rows that begin with a time or a frequency",
    )


def _without_end(lines: TextLines) -> TextLines:
    """Without a last column that is empty in every row, as a delimiter at the end of lines makes it."""
    mark = lines.delimiter
    while mark.strip(" ") and all(line.text.rstrip(" ").endswith(mark) for line in lines.body):
        columns = len(cells(lines.body[0].text, mark))
        body = tuple(replace(line, text=line.text.rstrip(" ")[:-1]) for line in lines.body)
        above = tuple(_shortened(line, mark, columns) for line in lines.above)
        lines = replace(lines, above=above, body=body)
    return lines


def _shortened(line: Line, mark: str, columns: int) -> Line:
    row = cells(line.text, mark)
    return replace(line, text=line.text.rstrip(" ").rpartition(mark)[0]) if len(row) == columns else line


def _without_groups(lines: TextLines, where: str) -> TextLines:
    """Without marks between thousands, which show where a number has both marks. Seconds of a clock have none.

    Raises:
        FormatError: a mark may be either.
    """
    if lines.delimiter == "," and not lines.clock:
        return lines
    cut = [line.text.partition(lines.delimiter) if lines.clock else ("", "", line.text) for line in lines.body]
    mark = _group_mark(lines.body, [rest for _, _, rest in cut], where)
    if not mark:
        return lines
    body = [replace(x, text=a + b + c.replace(mark, "")) for x, (a, b, c) in zip(lines.body, cut, strict=True)]
    return replace(lines, body=tuple(body))


def _group_mark(lines: Sequence[Line], texts: Sequence[str], where: str) -> str:
    """The mark that stands between thousands, "" if there is none."""
    for pattern, mark in ((_POINT_AFTER, ","), (_COMMA_AFTER, ".")):
        if any(pattern.search(text) for text in texts):
            return mark
    if not any("," in text for text in texts):
        return ""
    for mark in (",", "."):
        other = "." if mark == "," else ","
        found = [(line, cell) for line, text in zip(lines, texts, strict=True) for cell in _MARKED[mark].findall(text)]
        if found and all(_GROUPED[mark].fullmatch(cell) for _, cell in found) and _has_decimal(texts, other):
            line, cell = found[0]
            what = f"line {line.number}: {cell!r} beside numbers with decimal {other!r} may be in thousands"
            raise FormatError(what, where=where, remedy="export the file with one decimal mark, and without thousands")
    return ""


def _has_decimal(texts: Sequence[str], mark: str) -> bool:
    """Whether a mark stands where none of thousands can."""
    return any(not _GROUPED[mark].fullmatch(cell) for text in texts for cell in _MARKED[mark].findall(text))


def _with_seconds(lines: TextLines) -> TextLines:
    """With seconds where the first column holds clock times, or the first two date and clock."""
    mark = lines.delimiter
    rows = [cells(line.text, mark) for line in lines.body]
    joined = is_date(rows[0][0]) and not is_clock(rows[0][0])
    moments = [" ".join(row[: 1 + joined]) for row in rows]
    if not is_clock(moments[0]):
        return lines
    mark = "\t" if mark == "," else mark
    body = [
        replace(line, text=mark.join([seconds, *row[1 + joined :]]))
        for line, seconds, row in zip(lines.body, seconds_of(moments), rows, strict=True)
    ]
    above = [cells(line.text, lines.delimiter) for line in lines.above]
    heads = [replace(line, text=mark.join(row[joined:])) for line, row in zip(lines.above, above, strict=True)]
    return replace(lines, above=tuple(heads), body=tuple(body), delimiter=mark, clock=True)
