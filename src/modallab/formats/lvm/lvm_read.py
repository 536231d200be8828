"""LabVIEW measurement files (.lvm) as segments of channels.

Source: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)" (2023): a header of names and
values, then segments, each with a header of one value for each channel, a line of column names, and rows. Columns of x
there are none, one, or one before each channel; a channel's values stand above its samples. Segments that a program
wrote later may share the header of the first.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.csv.csv_cells import number
from modallab.formats.csv.digits import half_last_digits
from modallab.formats.csv.text_lines import Line, decoded

FIRST = "LabVIEW Measurement"
_END = "***End_of_Header***"
_SPECIAL = ("***Start_Special***", "***End_Special***")
_AGAIN = "write the file again, or export the records as TDMS"


@dataclass(frozen=True, eq=False, slots=True)
class LvmChannel:
    """One channel of a segment.

    Attributes:
        name: of its column.
        unit: as it is written, "" for none.
        dimension: of its abscissa, as Time; "" where the file says none.
        x_unit: of its abscissa, "" for none.
        start: date and time of the segment, in ISO 8601; "" where the file says none.
        x0: first abscissa.
        step: from sample to sample; 0 if the file does not say.
        step_error: half of the last digit with which the step was written.
        x: (n,) its abscissae; empty if there is no column of them.
        x_error: (n,) half of the last digit of each.
        samples: (n,)
    """

    name: str
    unit: str
    dimension: str
    x_unit: str
    start: str
    x0: float
    step: float
    step_error: float
    x: NDArray[np.float64]
    x_error: NDArray[np.float64]
    samples: NDArray[np.float64]


Header = Mapping[str, Sequence[str]]


def has_header(path: Path) -> bool:
    """Whether a file begins with the header of the format; LabVIEW can leave it out."""
    return decoded(path).startswith(FIRST)


def read_lvm(path: Path) -> tuple[tuple[LvmChannel, ...], ...]:
    """The segments of a file, each with its channels.

    Raises:
        FormatError: no such file, cut off or damaged; names the line and what stands there.
    """
    where = str(path)
    lines = _without_special([Line(k, text) for k, text in enumerate(decoded(path).splitlines(), start=1)])
    separator = _separator(lines)
    general, rest = _header(lines, separator, where)
    segments: list[tuple[LvmChannel, ...]] = []
    while rest:
        head, rest = _header(rest, separator, where)
        end = next((k for k, line in enumerate(rest) if k and _is_tag(_cells(line, separator)[0])), len(rest))
        body = _Body(rest[0], rest[1:end], separator, where)
        segments += [one.channels() for one in _Segment(general, head, body).parts()]
        rest = rest[end:]
    if not segments:
        raise FormatError("holds a header and no segment", where=where, remedy=_AGAIN)
    return tuple(segments)


def _without_special(lines: Sequence[Line]) -> list[Line]:
    """The lines that are not empty, and not within a block that a program keeps for itself."""
    kept: list[Line] = []
    inside = False
    for line in lines:
        inside = line.text.startswith(_SPECIAL[0]) or inside
        if line.text.strip() and not inside:
            kept.append(line)
        inside = inside and not line.text.startswith(_SPECIAL[1])
    return kept


def _separator(lines: Sequence[Line]) -> str:
    line = next((line.text for line in lines if line.text.startswith("Separator")), "")
    return "," if line.removeprefix("Separator")[1:].lower().startswith("comma") else "\t"


def _cells(line: Line, separator: str) -> list[str]:
    return [cell.strip() for cell in line.text.split(separator)]


def _is_tag(cell: str) -> bool:
    """Whether a cell begins a line of a header, and not a row."""
    return bool(cell) and number(cell) is None


def _header(lines: Sequence[Line], separator: str, where: str) -> tuple[Header, list[Line]]:
    """Names and values up to the end of a header, and the lines after it, of which there must be one."""
    end = next((k for k, line in enumerate(lines) if line.text.startswith(_END)), None)
    if end is None:
        found = f"is cut off: the header that begins at line {lines[0].number} has no end"
        raise FormatError(found, where=where, remedy="copy the file again")
    rows = [_cells(line, separator) for line in lines[:end]]
    return {row[0]: row[1:] for row in rows}, list(lines[end + 1 :])


@dataclass(frozen=True, slots=True)
class _Body:
    """A segment's line of names and its rows."""

    names: Line
    rows: Sequence[Line]
    separator: str
    where: str

    def cells(self, line: Line) -> list[str]:
        """What stands in a line."""
        return _cells(line, self.separator)

    @property
    def begins_with_number(self) -> bool:
        """Whether something stands in the first place of the first row."""
        return bool(self.rows) and bool(self.cells(self.rows[0])[0])

    def columns(self, places: Sequence[int]) -> list[list[tuple[str, Line]]]:
        """What stands in the columns at these places, each to its last number, and in which lines.

        Raises:
            FormatError: no rows.
        """
        if not self.rows:
            what = f"is cut off: no sample stands below line {self.names.number}"
            raise FormatError(what, where=self.where, remedy="copy the file again")
        found: list[list[tuple[str, Line]]] = [[] for _ in places]
        for line in self.rows:
            row = self.cells(line)
            for column, place in zip(found, places, strict=True):
                if place < len(row) and row[place]:
                    column.append((row[place], line))
        return found

    def number(self, cell: str, decimal: str, line: Line) -> float:
        """The number in a cell.

        Raises:
            FormatError: there is none.
        """
        try:
            return float(cell.replace(decimal, "."))
        except ValueError as error:
            what = f"line {line.number}: {cell!r} is no number with the decimal mark {decimal!r} that the header says"
            raise FormatError(what, where=self.where, remedy=_AGAIN) from error


@dataclass(frozen=True, slots=True)
class _Segment:
    """The file's header, a segment's, and what stands below it."""

    general: Header
    head: Header
    body: _Body

    def parts(self) -> Iterator["_Segment"]:
        """Itself, or the segments that share its header: each has as many rows as the header says samples.

        Where a column of x runs on from one to the next, they are one.

        Raises:
            FormatError: there are fewer rows than samples.
        """
        count = max((int(n) for n in self.head.get("Samples", ()) if n.isdigit()), default=0)
        rows = self.body.rows
        if 0 < len(rows) < count and not self._is_thinned:
            what = f"is cut off: below line {self.body.names.number} stand {len(rows)} of {count} samples"
            raise FormatError(what, where=self.body.where, remedy="copy the file again")
        begins = [0, *(k for k in range(count, len(rows), max(count, 1)) if count > 1 and not self._runs_on(k))]
        for first, last in zip(begins, [*begins[1:], len(rows)], strict=True):
            yield replace(self, body=replace(self.body, rows=rows[first:last]))

    @property
    def _is_thinned(self) -> bool:
        """Whether somebody left rows out: Samples and Delta_X say the duration that the column of x still has."""
        count = max((int(n) for n in self.head.get("Samples", ()) if n.isdigit()), default=0)
        if self._kind == "no" or not 1 < len(self.body.rows) < count:
            return False
        first, second = (self.body.number(self.body.cells(k)[0], self._decimal, k) for k in self.body.rows[:2])
        step, said = second - first, self._number("Delta_X", 0)
        return step > 1.5 * said and abs(len(self.body.rows) * step - count * said) <= step

    def _runs_on(self, row: int) -> bool:
        """Whether the column of x goes on at a row as it began."""
        if self._kind == "no":
            return False
        cells = [(self.body.cells(line)[0], line) for line in (self.body.rows[k] for k in (0, 1, row - 1, row))]
        x = [self.body.number(cell, self._decimal, line) for cell, line in cells]
        return 0 < x[3] - x[2] < 1.5 * (x[1] - x[0])

    def channels(self) -> tuple[LvmChannel, ...]:
        """The channels, in the order of their columns.

        Raises:
            FormatError: no number of them, no rows, or something that is no number.
        """
        count = int(self._number("Channels", 0))
        if count < 1:
            found = f"the header above line {self.body.names.number} says no number of channels"
            raise FormatError(found, where=self.body.where, remedy=_AGAIN)
        columns = self.body.columns([*(self._column(k) for k in range(count)), *self._columns_of_x(count)])
        return tuple(self._channel(k, columns[k], columns[count:]) for k in range(count))

    def _column(self, k: int) -> int:
        if self._kind == "multi":
            return 2 * k + 1
        # Without a column of x its place is there all the same, and empty; some writers leave it out in the rows.
        return k if self._kind == "no" and self.body.begins_with_number else k + 1

    def _columns_of_x(self, count: int) -> list[int]:
        return {"multi": [2 * k for k in range(count)], "no": []}.get(self._kind, [0])

    def _channel(
        self, k: int, cells: Sequence[tuple[str, Line]], of_x: Sequence[Sequence[tuple[str, Line]]]
    ) -> LvmChannel:
        names = self.body.cells(self.body.names)[1 :: 2 if self._kind == "multi" else 1]
        x = next(iter(of_x[k : k + 1] or of_x), ())
        # One column of x is that of the channels that are as long as it.
        x = x if len(x) == len(cells) else ()
        abscissae = self._values(x)
        return LvmChannel(
            name=names[k] if k < len(names) else f"channel {k}",
            unit=self._value("Y_Unit_Label", k),
            dimension=self._value("X_Dimension", k),
            x_unit=self._value("X_Unit_Label", k),
            start=self._start(k),
            x0=self._number("X0", k),
            step=0.0 if self._is_thinned else self._number("Delta_X", k),
            step_error=float(half_last_digits([self._plain(self._value("Delta_X", k))], np.ones(1))[0]),
            x=abscissae,
            x_error=half_last_digits([self._plain(cell) for cell, _ in x], abscissae) if x else np.empty(0),
            samples=self._values(cells),
        )

    def _values(self, cells: Sequence[tuple[str, Line]]) -> NDArray[np.float64]:
        return np.array([self.body.number(cell, self._decimal, line) for cell, line in cells])

    def _plain(self, cell: str) -> str:
        return cell.replace(self._decimal, ".")

    @property
    def _kind(self) -> str:
        return (self.general.get("X_Columns") or ["One"])[0].lower()

    @property
    def _decimal(self) -> str:
        """The decimal mark; where the header does not say it, as in version 1, that of the first row."""
        mark = (self.general.get("Decimal_Separator") or [""])[0]
        comma = self.body.separator != "," and bool(self.body.rows) and "," in self.body.rows[0].text
        return mark or ("," if comma else ".")

    def _value(self, key: str, k: int) -> str:
        values = self.head.get(key) or ()
        place = 2 * k if self._kind == "multi" else k
        return values[place] if place < len(values) else ""

    def _number(self, key: str, k: int) -> float:
        cell = self._value(key, k)
        return self.body.number(cell, self._decimal, self.body.names) if cell else 0.0

    def _start(self, k: int) -> str:
        date, time = self._value("Date", k).replace("/", "-"), self._value("Time", k).replace(",", ".")
        return f"{date}T{time}" if date and time else ""
