"""LabVIEW measurement files (.lvm) as segments of channels.

Source: National Instruments, "Specification for the LabVIEW Measurement File (.lvm)" (2023): a header of names and
values, then segments, each with a header of one value for each channel, a line of column names, and rows. Columns of x
there are none, one, or one before each channel.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
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
        start: date and time of the segment, in ISO 8601; "" where the file says none.
        x0: first abscissa.
        step: from sample to sample; 0 if the file does not say.
        x: (n,) its abscissae; empty if there is no column of them.
        samples: (n,)
    """

    name: str
    unit: str
    start: str
    x0: float
    step: float
    x: NDArray[np.float64]
    samples: NDArray[np.float64]


Header = Mapping[str, Sequence[str]]


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
        end = next((k for k, line in enumerate(rest) if _cells(line, separator)[0] == "Channels"), len(rest))
        segments.append(_Segment(general, head, _Body(rest[0], rest[1:end], separator, where)).channels())
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
    said = next((line.text for line in lines if line.text.startswith("Separator")), "")
    return "," if said.removeprefix("Separator")[1:].lower().startswith("comma") else "\t"


def _cells(line: Line, separator: str) -> list[str]:
    return [cell.strip() for cell in line.text.split(separator)]


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

    def numbers(self, decimal: str, places: Sequence[int]) -> list[NDArray[np.float64]]:
        """The columns at these places, each to its last number.

        Raises:
            FormatError: no rows, or something that is no number.
        """
        if not self.rows:
            what = f"is cut off: no sample stands below line {self.names.number}"
            raise FormatError(what, where=self.where, remedy="copy the file again")
        found: list[list[float]] = [[] for _ in places]
        for line in self.rows:
            row = self.cells(line)
            for column, place in zip(found, places, strict=True):
                cell = row[place] if place < len(row) else ""
                if cell:
                    column.append(self.number(cell, decimal, line))
        return [np.array(column) for column in found]

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

    def channels(self) -> tuple[LvmChannel, ...]:
        count = int(self._number("Channels", 0))
        if count < 1:
            found = f"the header above line {self.body.names.number} says no number of channels"
            raise FormatError(found, where=self.body.where, remedy=_AGAIN)
        with_x = {"multi": [2 * k for k in range(count)], "one": [0] * count}.get(self._kind, [])
        # Without a column of x its place is there all the same, and empty; some writers leave it out in the rows.
        shift = 0 if self._kind == "no" and self.body.begins_with_number else 1
        places = [2 * k + 1 for k in range(count)] if self._kind == "multi" else [k + shift for k in range(count)]
        columns = self.body.numbers(self._decimal, [*places, *with_x])
        names = self.body.cells(self.body.names)[1 :: 2 if self._kind == "multi" else 1]
        return tuple(
            LvmChannel(
                name=names[k] if k < len(names) else f"channel {k}",
                unit=self._value("Y_Unit_Label", k),
                start=self._start(k),
                x0=self._number("X0", k),
                step=self._number("Delta_X", k),
                x=columns[count + k] if with_x else np.empty(0),
                samples=columns[k],
            )
            for k in range(count)
        )

    @property
    def _kind(self) -> str:
        return (self.general.get("X_Columns") or ["One"])[0].lower()

    @property
    def _decimal(self) -> str:
        return (self.general.get("Decimal_Separator") or ["."])[0] or "."

    def _value(self, key: str, k: int) -> str:
        values = self.head.get(key) or ()
        return values[k] if k < len(values) else ""

    def _number(self, key: str, k: int) -> float:
        cell = self._value(key, k)
        return self.body.number(cell, self._decimal, self.body.names) if cell else 0.0

    def _start(self, k: int) -> str:
        date, time = self._value("Date", k).replace("/", "-"), self._value("Time", k).replace(self._decimal, ".")
        return f"{date}T{time}" if date and time else ""
