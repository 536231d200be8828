"""The sets of a universal file, divided by the marks between them; what is binary in them is skipped by its length."""

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyuff

from modallab.core.errors import FormatError
from modallab.formats.uff.uff_numbers import EXPORT_AGAIN, numbers, plain_line

DELIMITER = b"-1"
FUNCTION_SET = 58
HEAD_LINES = 11
_MARK_COLUMNS = 6
_END = re.compile(rb"\r\n|\n|\r")
_PART_BYTES = {2: 4, 4: 8, 5: 8, 6: 16}
"""Bytes of an ordinate by its type: real and complex, single and double."""
_LITTLE, _IEEE = 1, (0, 2)


@dataclass(frozen=True, eq=False, slots=True)
class RawSet:
    """One set.

    Attributes:
        place: its place in the file, from 1.
        kind: number of the dataset, 0 if there is none.
        lines: of text below the number, without their ends.
        payload: what follows them in binary; None in a set of text.
        order: "<" or ">", the order of bytes in the payload.
    """

    place: int
    kind: int
    lines: tuple[str, ...]
    payload: bytes | None = None
    order: str = "<"


@dataclass(frozen=True, slots=True)
class Form:
    """Record 7 of dataset 58: what the ordinates are, how many, and the abscissa if it is even."""

    kind: int
    count: int
    even: bool
    start: float
    step: float

    @property
    def parts(self) -> int:
        """Real numbers in an ordinate."""
        return 1 if self.kind in (2, 4) else 2


def divide(path: Path) -> tuple[RawSet, ...]:
    """The sets of a universal file.

    Raises:
        FormatError: no universal file, cut off, or with a binary set that does not hold what it announces.
    """
    return tuple(_Divider(path.read_bytes(), str(path)).sets())


def form_of(lines: Sequence[str], where: str) -> Form:
    """The form of a function.

    Raises:
        FormatError: the set has no such record, or it announces what the format does not know.
    """
    fields = numbers(lines[6:7], where) if len(lines) >= HEAD_LINES else ()
    if len(fields) < 5 or not np.isfinite(fields[:3]).all():
        raise FormatError("is cut off or damaged within its head", where=where, remedy=EXPORT_AGAIN)
    kind, count, even = (int(value) for value in fields[:3])
    if kind not in _PART_BYTES:
        raise FormatError(
            f"has ordinates of type {kind}; the format knows 2, 4, 5 and 6", where=where, remedy=EXPORT_AGAIN
        )
    return Form(kind, count, bool(even), float(fields[3]), float(fields[4]))


def decoded(sets: Sequence[RawSet], kind: int, where: str) -> tuple[dict[str, Any], ...]:
    """All sets of text of one type, as pyuff decodes them.

    Raises:
        FormatError: one cannot be decoded.
    """
    wanted = [one for one in sets if one.kind == kind]
    if not wanted:
        return ()
    with tempfile.TemporaryDirectory(prefix="modallab-uff-") as folder:
        file = Path(folder) / "sets.uff"
        file.write_text("".join(_as_text(one) for one in wanted), encoding="utf-8")
        return tuple(_decoded(file, k, one, where) for k, one in enumerate(wanted))


def _as_text(one: RawSet) -> str:
    lines = [plain_line(line) for line in one.lines]
    # Blank lines say something in the five identification lines only.
    kept = [line or " " for line in lines[:10]] + [line for line in lines[10:] if line]
    return "\n".join(["    -1", f"{one.kind:6d}", *kept, "    -1", ""])


def _decoded(file: Path, index: int, one: RawSet, where: str) -> dict[str, Any]:
    try:
        with np.errstate(all="ignore"):
            return cast("dict[str, Any]", pyuff.UFF(str(file)).read_sets(index))
    except Exception as error:  # pyuff raises plain Exception.
        raise FormatError(f"set {one.place} cannot be decoded", where=where, remedy=EXPORT_AGAIN) from error


class _Divider:
    def __init__(self, content: bytes, where: str) -> None:
        self._content, self._where, self._at, self._place = content, where, 0, 0

    def sets(self) -> list[RawSet]:
        found = [self._set() for line in iter(self._line, None) if _is_mark(line)]
        if not found:
            raise FormatError(
                "is no universal file: it has no line '    -1'",
                where=self._where,
                remedy="name a universal file, or give this file the ending of its own kind",
            )
        return found

    def _line(self) -> bytes | None:
        if self._at >= len(self._content):
            return None
        end = _END.search(self._content, self._at)
        stop, after = (len(self._content),) * 2 if end is None else end.span()
        line, self._at = self._content[self._at : stop], after
        return line

    def _set(self) -> RawSet:
        self._place += 1
        head = self._line() or b""
        found = re.match(rb"\s*(\d+)\s*([bB]?)", head)
        kind = int(found[1]) if found is not None and len(found[1]) < 7 else 0
        if kind == FUNCTION_SET and found is not None and found[2]:
            return self._binary(head[found.end() :].decode("ascii", "replace"))
        lines: list[str] = []
        for line in iter(self._line, None):
            if _is_mark(line):
                return RawSet(self._place, kind, tuple(lines))
            lines.append(line.decode("utf-8", "replace"))
        raise self._cut_off()

    def _binary(self, header: str) -> RawSet:
        where = f"{self._where}, set {self._place}"
        lines = tuple((self._line() or b"").decode("utf-8", "replace") for _ in range(HEAD_LINES))
        form = form_of(lines, where)
        order, fp, _, announced = [int(v) for v in [*numbers([header], where), 0, 0, 0, 0][:4]]
        if fp not in _IEEE or order not in (1, 2):
            found = f"holds binary numbers of format {fp} and order {order}; IEEE numbers (2) of order 1 or 2 are read"
            raise FormatError(found, where=where, remedy="export it as text, or as IEEE numbers")
        # The length it announces, else that of what it announces: programs write 0 there, or count otherwise.
        for length in (announced, *_lengths(form)):
            if self._ends_after(length):
                payload, self._at = self._content[self._at : self._at + length], self._at + length
                self._line_of_mark()
                return RawSet(self._place, FUNCTION_SET, lines, payload, "<" if order == _LITTLE else ">")
        if self._at + _lengths(form)[-1] > len(self._content):
            raise self._cut_off()
        raise FormatError("does not end where its numbers do", where=where, remedy=EXPORT_AGAIN)

    def _ends_after(self, length: int) -> bool:
        begin, stop = self._at, self._at + length
        if length <= 0 or stop > len(self._content):
            return False
        self._at = stop
        found = self._line_of_mark()
        self._at = begin
        return found

    def _line_of_mark(self) -> bool:
        """Whether the next line that is not blank is a mark; goes behind it."""
        line = next((line for line in iter(self._line, None) if line.strip()), b"")
        return _is_mark(line)

    def _cut_off(self) -> FormatError:
        found = f"is cut off: set {self._place} does not end"
        return FormatError(found, where=self._where, remedy=EXPORT_AGAIN)


def _lengths(form: Form) -> tuple[int, ...]:
    """Bytes of the numbers of a form; beside an uneven abscissa in single or in the ordinates' precision."""
    value = _PART_BYTES[form.kind]
    sizes = (value,) if form.even else (4 + value, value // form.parts + value)
    return tuple(form.count * size for size in sizes)


def _is_mark(line: bytes) -> bool:
    return line.strip() == DELIMITER and len(line.rstrip()) <= _MARK_COLUMNS
