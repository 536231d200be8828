"""The functions in a universal file: dataset 58, as text or binary (58b)."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.uff.uff_numbers import EXPORT_AGAIN, numbers
from modallab.formats.uff.uff_sets import FUNCTION_SET, HEAD_LINES, Form, RawSet, decoded, divide, form_of
from modallab.formats.unit_text import normal_unit, to_hertz, to_seconds

__all__ = ["KINDS", "Function", "UniversalFile", "read_datasets", "read_functions"]

UNITS_SET = 164
KINDS = {1: "time record", 2: "auto spectrum", 3: "cross spectrum", 4: "FRF", 6: "coherence", 9: "PSD", 12: "spectrum"}

_TIME_RECORD, _OVER_FREQUENCY = 1, (4, 6)
_DIGIT = 0.5e-5
"""Half of the last digit of a mantissa as the format writes it (E13.5)."""
_DOF_COLUMNS = (5, 10, 5, 10, 11, 10, 4, 11, 10, 4)
_DOF_WORDS = re.compile(r"(\d+) +(\d+) +(\d+) +(\d+) +(\S.*?) +(-?\d+) +(-?\d+) +(\S.*?) +(-?\d+) +(-?\d+)")
_WHOLE = re.compile(r"([+-]?\d+)?")
_AXIS_COLUMNS = (10, 5, 5, 5, 21, 21)
_PER_LINE = 6
"""Most numbers in a line: by so many less one the last line may be filled up."""


@dataclass(frozen=True, eq=False)
class Function:
    """One set of type 58.

    Attributes:
        place: its place among all sets of the file, from 1.
        kind: function type of the format: 1 a time record, 4 an FRF, 6 a coherence.
        names: entity name, identification lines and the ordinate's label, as written.
        node: node of the response, 0 if unknown.
        direction: 1, 2, 3 for x, y, z, negative for the other sense; 0 if unknown.
        reference_node: node of the excitation, 0 if unknown.
        reference_direction: as `direction`.
        even: whether the abscissa was given by its step.
        axis: (n,) abscissa, of time records in s, of FRFs and coherences in Hz.
        axis_error: half of the last digit with which the abscissa (or its step, relative to it) was written.
        start_error: the same of its first value.
        values: (n,) real or complex.
        unit: unit of the ordinate, "" if none is written.
        divisor_unit: unit of its denominator, "" if none is written.
        specific: what the ordinate is: 8, 11, 12 displacement, velocity, acceleration, 13 force.
        divisor_specific: the same of the denominator.
    """

    place: int
    kind: int
    names: tuple[str, ...]
    node: int
    direction: int
    reference_node: int
    reference_direction: int
    even: bool
    axis: NDArray[np.float64]
    axis_error: float
    start_error: float
    values: NDArray[np.float64] | NDArray[np.complex128]
    unit: str
    divisor_unit: str
    specific: int
    divisor_specific: int


@dataclass(frozen=True, slots=True)
class FileUnits:
    """What dataset 164 says: the code of the units, 1 for SI, and what SI is multiplied by to give the file's numbers.

    Attributes:
        code: of the format.
        length: of the file's unit of length to a metre.
        force: of its unit of force to a newton.
    """

    code: int
    length: float
    force: float


@dataclass(frozen=True, eq=False)
class UniversalFile:
    """What a universal file holds: its functions, its units (None if not said), other sets by type."""

    functions: tuple[Function, ...]
    units: FileUnits | None
    others: tuple[int, ...]


def read_functions(path: Path) -> UniversalFile:
    """Read all functions of a universal file.

    Raises:
        FormatError: no universal file, cut off, or with a set that does not hold what it announces.
    """
    where, sets = str(path), divide(path)
    functions = tuple(_function(one, f"{where}, set {one.place}") for one in sets if one.kind == FUNCTION_SET)
    units = [_file_units(content) for content in decoded(sets, UNITS_SET, where)]
    return UniversalFile(
        functions=functions,
        units=units[0] if units else None,
        others=tuple(one.kind for one in sets if one.kind not in (FUNCTION_SET, UNITS_SET)),
    )


def _file_units(content: dict[str, Any]) -> FileUnits:
    return FileUnits(
        code=int(content.get("units_code") or 0),
        length=float(content.get("length") or 1.0),
        force=float(content.get("force") or 1.0),
    )


def read_datasets(path: Path, kind: int) -> tuple[dict[str, Any], ...]:
    """All sets of one type, as pyuff decodes them.

    Raises:
        FormatError: no universal file, cut off, or with a set that cannot be decoded.
    """
    return decoded(divide(path), kind, str(path))


def _function(one: RawSet, where: str) -> Function:
    form = form_of(one.lines, where)
    axis, values = _data(one, form, where)
    kind, name, node, direction, reference, along = _degrees_of_freedom(one.lines[5], where)
    (_, along_unit), (specific, unit), (divisor, divisor_unit) = (_quantity(line, where) for line in one.lines[7:10])
    scale = _scale_of_axis(kind, along_unit, where)
    return Function(
        place=one.place,
        kind=kind,
        names=(name, *(one.lines[k][:80].strip() for k in (0, 1, 3, 4)), _fields(one.lines[8], _AXIS_COLUMNS)[4]),
        node=node,
        direction=direction,
        reference_node=reference,
        reference_direction=along,
        even=form.even,
        axis=scale * axis,
        axis_error=scale * _last_digit(form.step if form.even else float(np.abs(axis).max())),
        start_error=scale * _last_digit(abs(float(axis[0]))),
        values=values,
        unit=unit,
        divisor_unit=divisor_unit,
        specific=specific,
        divisor_specific=divisor,
    )


def _scale_of_axis(kind: int, unit: str, where: str) -> float:
    """What turns an abscissa into s or Hz; functions that are not read keep theirs."""
    if kind == _TIME_RECORD:
        return to_seconds(unit, f"{where}, abscissa")
    return to_hertz(unit, f"{where}, abscissa") if kind in _OVER_FREQUENCY else 1.0


def _data(
    one: RawSet, form: Form, where: str
) -> tuple[NDArray[np.float64], NDArray[np.float64] | NDArray[np.complex128]]:
    """(n,) abscissa and (n,) ordinates.

    Raises:
        FormatError: other numbers than announced; zeros that fill the last line of text are none.
    """
    flat = numbers(one.lines[HEAD_LINES:], where) if one.payload is None else _from_bytes(one, form)
    columns = form.parts + (not form.even)
    surplus = flat[form.count * columns :]
    if form.count < 1 or flat.size < form.count * columns or surplus.size >= _PER_LINE or surplus.any():
        raise FormatError(
            f"is cut off or damaged: {flat.size // columns} of {form.count} values are there",
            where=where,
            remedy=EXPORT_AGAIN,
        )
    table = flat[: form.count * columns].reshape(form.count, columns)
    axis = (form.start + form.step * np.arange(form.count) if form.even else table[:, 0]).astype(np.float64)
    first = 0 if form.even else 1
    return axis, table[:, first].copy() if form.parts == 1 else table[:, first] + 1j * table[:, first + 1]


def _from_bytes(one: RawSet, form: Form) -> NDArray[np.float64]:
    """Binary numbers, the abscissa among them; it may be of single precision beside ordinates of double."""
    assert one.payload is not None
    size = 4 if form.kind in (2, 5) else 8
    kind = f"{one.order}f{size}"
    mixed = np.dtype([("x", f"{one.order}f4"), ("y", kind, (form.parts,))])
    if not form.even and size == 8 and len(one.payload) == form.count * mixed.itemsize:
        rows = np.frombuffer(one.payload, mixed)
        return np.column_stack([rows["x"], rows["y"]]).ravel()
    whole = len(one.payload) // size * size
    return np.frombuffer(one.payload[:whole], kind).astype(np.float64)


def _degrees_of_freedom(line: str, where: str) -> tuple[int, str, int, int, int, int]:
    """Function type, response entity, node and direction of the response and of the reference.

    Raises:
        FormatError: there are none. Names longer than their ten columns move what follows them; blanks tell it then.
    """
    fields = _fields(line, _DOF_COLUMNS)
    if any(not _WHOLE.fullmatch(fields[k]) for k in (0, 5, 6, 8, 9)):
        apart = _DOF_WORDS.fullmatch(line.strip())
        fields = list(apart.groups()) if apart is not None else fields
    kind, node, direction, reference, along = (_whole(fields[k], where) for k in (0, 5, 6, 8, 9))
    return kind, fields[4], node, direction, reference, along


def _fields(line: str, widths: tuple[int, ...]) -> list[str]:
    """What stands in the columns of a line."""
    stops = np.cumsum(widths)
    return [line[stop - width : stop].strip() for stop, width in zip(stops, widths, strict=True)]


def _quantity(line: str, where: str) -> tuple[int, str]:
    """Specific data type and unit of an axis."""
    fields = _fields(line, _AXIS_COLUMNS)
    return _whole(fields[0], where), normal_unit(fields[5])


def _whole(text: str, where: str) -> int:
    try:
        return int(text or 0)
    except ValueError as error:
        raise FormatError(f"{text!r} in its head is no whole number", where=where, remedy=EXPORT_AGAIN) from error


def _last_digit(number: float) -> float:
    if not (np.isfinite(number) and number > 0):
        return 0.0
    return _DIGIT * 10.0 ** float(np.floor(np.log10(number)))
