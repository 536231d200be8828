"""FRFs and modes in the CSV files that this program exports."""

import json
import re
from collections.abc import Collection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, FormatError
from modallab.core.frf import UNIT, Frf, FrfQuantity
from modallab.core.rig import Rig
from modallab.formats.csv.csv_table import Table, read_table
from modallab.formats.modes import ModeShapes

_PAIR = re.compile(r"(?P<part>re|im|coherence) (?P<output>.+)/p(?P<point>\d+|None)")
_SHAPE = re.compile(r"(?P<part>re|im) phi (?P<output>.+)")
_FREQUENCY, _DAMPING = "frequency", "damping ratio"
_AGAIN = "export the file again"


def is_frf(table: Table) -> bool:
    """Whether a table is one of FRFs as this program writes them."""
    return table.names[:1] == (_FREQUENCY,) and any(_PAIR.fullmatch(name) for name in table.names)


def frf_of(table: Table, rig: Rig, where: str) -> Frf:
    """The FRFs of a table, in SI.

    Raises:
        FormatError: its remark says no quantity, or it has other columns.
        DataError: a pair is missing, an output is no response of the rig, or numbers that no FRF has.
    """
    quantity: FrfQuantity | None = next((q for q, unit in UNIT.items() if table.remark == f"# {q} in {unit}"), None)
    columns = {name: column for name, column in zip(table.names, table.values.T, strict=True) if name != _FREQUENCY}
    found = {name: _PAIR.fullmatch(name) for name in columns}
    strange = [name for name, match in found.items() if match is None]
    if quantity is None or strange:
        what = f"column {strange[0]!r}" if strange else f"the remark {table.remark!r}"
        raise FormatError(f"{what} is none of an FRF", where=where, remedy=_AGAIN)
    pairs = [(match["part"], match["output"], match["point"]) for match in found.values() if match is not None]
    outputs = tuple(dict.fromkeys(output for _, output, _ in pairs))
    points = tuple(dict.fromkeys(point for _, _, point in pairs))

    def matrix(part: str) -> NDArray[np.float64]:
        return np.array([[_column(columns, f"{part} {o}/p{p}", where) for p in points] for o in outputs])

    channels = {channel.name: channel for channel in rig.responses}
    _require_known(outputs, channels, where)
    frequency_hz = table.values[:, 0].copy()
    values = matrix("re") + 1j * matrix("im")
    return Frf(
        frequency_hz=frequency_hz,
        values=values,
        quantity=quantity,
        outputs=outputs,
        output_points=tuple(channels[output].point for output in outputs),
        input_points=tuple(None if point == "None" else int(point) for point in points),
        coherence=matrix("coherence") if any(part == "coherence" for part, _, _ in pairs) else None,
    )


def read_csv_modes(path: Path, rig: Rig) -> ModeShapes:
    """The modes of a file `modes_*.csv` of an export.

    Raises:
        FormatError: no table of modes, or cut off.
        DataError: a shape is at no response channel of the rig.
    """
    where, table = str(path), read_table(path)
    columns = dict(zip(table.names, table.values.T, strict=True))
    found = [match for name in table.names if (match := _SHAPE.fullmatch(name)) is not None]
    outputs = tuple(dict.fromkeys(match["output"] for match in found))
    channels = {channel.name: channel for channel in rig.responses}
    _require_known(outputs, channels, where)
    parts = [_column(columns, f"re phi {o}", where) + 1j * _column(columns, f"im phi {o}", where) for o in outputs]
    return ModeShapes(
        title=_title(table.remark, where),
        frequency_hz=_column(columns, _FREQUENCY, where),
        damping_ratio=_column(columns, _DAMPING, where),
        outputs=outputs,
        output_points=tuple(channels[output].point for output in outputs),
        modal_mass_kg=np.ones(len(table.values)),
        shapes=np.array(parts, dtype=np.complex128).reshape(len(outputs), -1).T,
    )


def _title(remark: str, where: str) -> str:
    try:
        return str(json.loads(remark.removeprefix("#"))["method"])
    except (ValueError, KeyError, TypeError) as error:
        raise FormatError(f"the remark {remark!r} is none of a table of modes", where=where, remedy=_AGAIN) from error


def _column(columns: dict[str, NDArray[np.float64]], name: str, where: str) -> NDArray[np.float64]:
    if name not in columns:
        raise DataError(f"has no column {name!r}", where=where, remedy=_AGAIN)
    return columns[name].copy()


def _require_known(outputs: tuple[str, ...], channels: Collection[str], where: str) -> None:
    strange = [output for output in outputs if output not in channels]
    if strange:
        raise DataError(
            f"{', '.join(strange)} is no response channel of the rig", where=where, remedy="give the rig of the export"
        )
