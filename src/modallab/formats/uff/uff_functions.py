"""The functions in a universal file: dataset 58, as text or binary (58b), decoded by pyuff and checked here.

pyuff drops a last set that does not end, and does not compare the values it finds with the number that was announced.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyuff
from numpy.typing import NDArray

from modallab.core.errors import FormatError
from modallab.formats.unit_text import normal_unit

DELIMITER = b"-1"
FUNCTION_SET = 58
UNITS_SET = 164
KINDS = {1: "time record", 2: "auto spectrum", 3: "cross spectrum", 4: "FRF", 6: "coherence", 9: "PSD", 12: "spectrum"}

_DIGIT = 0.5e-5
"""Half of the last digit of a mantissa as the format writes it (E13.5)."""
_MARK = b"    -1"
_HEAD_BYTES = 4096
_COPY_AGAIN = "copy the file again, or export it again from the analyser"


@dataclass(frozen=True, eq=False)
class Function:
    """One set of type 58.

    Attributes:
        place: its place among all sets of the file, from 1.
        kind: function type of the format: 1 a time record, 4 an FRF, 6 a coherence.
        names: entity name and identification lines, as written.
        node: node of the response, 0 if unknown.
        direction: 1, 2, 3 for x, y, z, negative for the other sense; 0 if unknown.
        reference_node: node of the excitation, 0 if unknown.
        reference_direction: as `direction`.
        even: whether the abscissa was given by its step.
        axis: (n,) abscissa.
        axis_error: half of the last digit with which the abscissa (or its step, relative to it) was written.
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
    values: NDArray[np.float64] | NDArray[np.complex128]
    unit: str
    divisor_unit: str
    specific: int
    divisor_specific: int


@dataclass(frozen=True, eq=False)
class UniversalFile:
    """What a universal file holds: its functions, its unit code (1 is SI, None if not said), other sets by type."""

    functions: tuple[Function, ...]
    units_code: int | None
    others: tuple[int, ...]


def read_functions(path: Path) -> UniversalFile:
    """Read all functions of a universal file.

    Raises:
        FormatError: no universal file, cut off, or with a set that does not hold what it announces.
    """
    source, types = _open(path)
    functions = [_function(source, k, str(path)) for k, kind in enumerate(types) if kind == FUNCTION_SET]
    units = [_read_set(source, k, str(path)).get("units_code") for k, kind in enumerate(types) if kind == UNITS_SET]
    return UniversalFile(
        functions=tuple(functions),
        units_code=int(units[0]) if units and units[0] is not None else None,
        others=tuple(kind for kind in types if kind not in (FUNCTION_SET, UNITS_SET)),
    )


def read_datasets(path: Path, kind: int) -> tuple[dict[str, Any], ...]:
    """All sets of one type, as pyuff decodes them.

    Raises:
        FormatError: no universal file, cut off, or with a set that cannot be decoded.
    """
    source, types = _open(path)
    return tuple(_read_set(source, k, str(path)) for k, found in enumerate(types) if found == kind)


def _open(path: Path) -> tuple[Any, list[int]]:
    _check_frame(path)
    try:
        source: Any = pyuff.UFF(str(path))
        return source, [int(kind) for kind in source.get_set_types()]
    except Exception as error:  # pyuff raises plain Exception.
        raise FormatError("cannot be divided into sets", where=str(path), remedy=_COPY_AGAIN) from error


def _check_frame(path: Path) -> None:
    content, where = path.read_bytes(), str(path)
    first = content[:_HEAD_BYTES].lstrip().splitlines()[:1]
    if not first or first[0].strip() != DELIMITER:
        raise FormatError(
            "is no universal file: it does not begin with a line '    -1'",
            where=where,
            remedy="name a universal file, or give this file the ending of its own kind",
        )
    marks, at = 0, content.find(_MARK)
    while at >= 0:
        # A mark fills its line: after it come the line's end, or blanks up to column 80.
        rest = content[at + len(_MARK) : at + 80]
        marks += rest[:1] in (b"", b"\n", b"\r") or not rest.strip(b" ")
        at = content.find(_MARK, at + 1)
    if marks % 2:
        raise FormatError(f"is cut off: set {(marks + 1) // 2} does not end", where=where, remedy=_COPY_AGAIN)


def _read_set(source: Any, index: int, where: str) -> dict[str, Any]:
    try:
        with np.errstate(all="ignore"):
            return cast("dict[str, Any]", source.read_sets(index))
    except Exception as error:  # pyuff raises plain Exception.
        raise FormatError(f"set {index + 1} cannot be decoded", where=where, remedy=_COPY_AGAIN) from error


def _function(source: Any, index: int, where: str) -> Function:
    content = _read_set(source, index, where)
    if "data" not in content:
        raise FormatError(
            f"set {index + 1} has ordinates of type {content.get('ord_data_type')}; the format knows 2, 4, 5 and 6",
            where=where,
            remedy=_COPY_AGAIN,
        )
    values = np.asarray(content["data"])
    if len(values) != content["num_pts"] or len(content["x"]) != len(values) or not len(values):
        raise FormatError(
            f"set {index + 1} is cut off or damaged: {len(values)} of {content['num_pts']} values are there",
            where=where,
            remedy=_COPY_AGAIN,
        )
    even = bool(content["abscissa_spacing"])
    axis = np.asarray(content["x"], dtype=np.float64)
    return Function(
        place=index + 1,
        kind=int(content["func_type"]),
        names=tuple(str(content[key]).strip() for key in ("rsp_ent_name", "id1", "id2", "id4", "id5")),
        node=int(content["rsp_node"]),
        direction=int(content["rsp_dir"]),
        reference_node=int(content["ref_node"]),
        reference_direction=int(content["ref_dir"]),
        even=even,
        axis=axis,
        axis_error=_last_digit(float(content["abscissa_inc"]) if even else float(np.abs(axis).max())),
        values=values,
        unit=normal_unit(str(content["ordinate_axis_units_lab"])),
        divisor_unit=normal_unit(str(content["orddenom_axis_units_lab"])),
        specific=int(content["ordinate_spec_data_type"]),
        divisor_specific=int(content["orddenom_spec_data_type"]),
    )


def _last_digit(number: float) -> float:
    if not (np.isfinite(number) and number > 0):
        return 0.0
    return _DIGIT * 10.0 ** float(np.floor(np.log10(number)))
