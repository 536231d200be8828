"""FRFs in tables that others wrote: complex numbers, or two columns for each FRF."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frequencies
from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.formats.csv.csv_heads import is_frequency
from modallab.formats.csv.csv_table import Table
from modallab.formats.csv.frf_heading import (
    FrfHeading,
    Part,
    frf_heading,
    is_left_out,
    is_level,
    reference_of,
    response_of,
)
from modallab.formats.frf_file import assumed_factor, rising, share_of_one, turned
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import frf_unit, normal_unit, to_hertz

Complex = NDArray[np.complex128]

_TO_RAD = {"deg": np.pi / 180, "rad": 1.0}
_PAIRS: tuple[tuple[Part, Part], ...] = (("re", "im"), ("magnitude", "phase"))


@dataclass(frozen=True, eq=False, slots=True)
class Column:
    """One column of a table of FRFs."""

    heading: FrfHeading
    real: Real
    imaginary: Real | None

    @property
    def is_bare(self) -> bool:
        """Whether it holds sizes without a unit."""
        return not self.heading.unit and self.heading.part in ("re", "magnitude", "complex")


def holds_frfs(table: Table) -> bool:
    """Whether a table is one of FRFs: its first column is a frequency, or it holds complex numbers."""
    if table.imaginary is not None:
        return True
    if not table.names or not is_frequency(table.names[0], table.units[0]):
        return False
    return any(heading.part != "complex" for heading in map(frf_heading, table.names[1:], table.units[1:]))


def columns_of(table: Table, rig: Rig | None, where: str) -> list[Column]:
    """The columns beside the frequency; without a header the FRFs of the rig's responses, in rig order.

    Raises:
        DataError: no header, and as many columns as no rig is given for.
    """
    names, units = table.names[1:], table.units[1:] or ("",) * (len(table.names) - 1)
    if not names:
        names = () if rig is None else tuple(c.name for c in rig.responses)
        units = ("",) * len(names)
        if len(names) != table.values.shape[1] - 1:
            raise DataError(
                f"has {table.values.shape[1]} columns and no header; an FRF is there for each of "
                f"{', '.join(names) or 'unknown responses'}",
                where=where,
                remedy='name its columns with --columns "frequency:Hz,Re a1:m/s^2/N,Im a1", or add such a header line',
            )
    angles = set(map(normal_unit, table.elsewhere)) & set(_TO_RAD)
    common, angle = _common_unit(table, where), angles.pop() if len(angles) == 1 else ""
    found: list[Column] = []
    for k, (name, unit) in enumerate(zip(names, units, strict=True), start=1):
        if not name:
            continue
        imaginary = None if table.imaginary is None else table.imaginary[:, k]
        is_complex = imaginary is not None and imaginary.any()
        heading = frf_heading(name, unit)
        if not heading.unit and heading.part != "coherence":
            heading = replace(heading, unit=angle if heading.part == "phase" else common)
        found.append(Column(heading, table.values[:, k], imaginary if is_complex else None))
    return found


def _common_unit(table: Table, where: str) -> str:
    """The one unit of FRFs that stands above a table without units; "" if there is none.

    Raises:
        DataError: there are several.
    """
    known = {unit: frf_unit(unit, "") for unit in map(normal_unit, table.elsewhere)}
    meant = {value: unit for unit, value in known.items() if value}
    if len(meant) > 1:
        raise DataError(
            f"has several units of FRFs above its columns, {' and '.join(sorted(meant.values()))}",
            where=where,
            remedy="write the unit of each FRF behind its name",
        )
    return next(iter(meant.values()), "")


def frf_of_table(table: Table, rig: Rig, options: ImportOptions, where: str) -> Frf:
    """The FRFs of a table, in SI.

    A number without a unit is in the unit of the rig's channel over that of its force. A magnitude in dB refers to 1 in
    SI, or to what stands behind "dB re".

    Raises:
        DataError: columns that are no FRF of the rig, that lack their phase or the unit of it, or units of no FRF.
    """
    frequency_hz = _frequency(table, where)
    groups: dict[tuple[str, int | None], dict[Part, Column]] = {}
    channels = {c.name: c for c in rig.responses}
    for column in columns_of(table, rig, where):
        if is_left_out(column.heading, rig, options):
            continue
        channel, point = response_of(column.heading, rig, where)
        parts = groups.setdefault((channel.name, options.drive_point if point is None else point), {})
        part: Part = "complex" if column.imaginary is not None else column.heading.part
        if part in parts:
            raise DataError(
                f"columns {parts[part].heading.text!r} and {column.heading.text!r} are of one FRF, by their names",
                where=where,
                remedy="name response and point of the force, as in Re a1/p10, in the file or with --columns",
            )
        parts[part] = column
    outputs = tuple(name for name in channels if any(output == name for output, _ in groups))
    points = tuple(dict.fromkeys(point for _, point in groups))
    _require_all(groups, outputs, points, where)
    quantities: set[FrfQuantity] = set()
    values = np.empty((len(outputs), len(points), len(frequency_hz)), np.complex128)
    for (output, point), parts in groups.items():
        quantity, found = _values(parts, channels[output], rig, where)
        values[outputs.index(output), points.index(point)] = turned(channels[output], rig) * found
        quantities.add(quantity)
    if len(quantities) != 1:
        raise DataError(
            f"holds FRFs of {' and '.join(sorted(quantities))}",
            where=where,
            remedy="give those of one quantity, and leave the channels of the other out with --ignore",
        )
    frequency_hz, values, coherence = rising(frequency_hz, values, _coherence(groups, outputs, points, where))
    check_frequencies(frequency_hz, where, even=False, resolution_hz=table.resolution)
    return Frf(
        frequency_hz=frequency_hz,
        values=values,
        quantity=quantities.pop(),
        outputs=outputs,
        output_points=tuple(channels[output].point for output in outputs),
        input_points=points,
        coherence=coherence,
    )


def _frequency(table: Table, where: str) -> Real:
    return table.values[:, 0] * to_hertz(table.units[0] if table.units else "", where)


def _require_all(
    groups: Mapping[tuple[str, int | None], object],
    outputs: tuple[str, ...],
    points: tuple[int | None, ...],
    where: str,
) -> None:
    missing = [f"{o} to point {p}" for o in outputs for p in points if (o, p) not in groups]
    if missing:
        raise DataError(
            f"has no FRF of {', '.join(missing)}", where=where, remedy="give every response to every force, or none"
        )


def _values(parts: Mapping[Part, Column], channel: Channel, rig: Rig, where: str) -> tuple[FrfQuantity, Complex]:
    column = parts.get("complex")
    if column is not None and column.imaginary is not None:
        quantity, factor = _factor(column.heading, channel, rig, where)
        return quantity, factor * (column.real + 1j * column.imaginary)
    if column is not None and "phase" in parts:
        # A column without a word for its part that has a phase beside it is the magnitude.
        parts = {**parts, "magnitude": column}
    for first, second in _PAIRS:
        if first in parts and second in parts:
            quantity, factor = _factor(parts[first].heading, channel, rig, where)
            one, two = parts[first], parts[second]
            if first == "re":
                return quantity, factor * (one.real + 1j * two.real)
            size = 10 ** (one.real / 20) if is_level(one.heading.unit) else one.real
            turn: Complex = np.exp(1j * two.real * _angle(two.heading, where))
            return quantity, factor * size * turn
    held = ", ".join(repr(column.heading.text) for column in parts.values())
    raise DataError(
        f"of {channel.name} only {held} is there, which is no complex number",
        where=where,
        remedy="give complex numbers, or two columns: Re and Im, or magnitude and phase",
    )


def _angle(heading: FrfHeading, where: str) -> float:
    if heading.unit not in _TO_RAD:
        raise DataError(
            f"column {heading.text!r}: {heading.unit!r} is no unit of a phase",
            where=where,
            remedy="write [deg] or [rad] behind its name",
        )
    return _TO_RAD[heading.unit]


def _factor(heading: FrfHeading, channel: Channel, rig: Rig, where: str) -> tuple[FrfQuantity, float]:
    assumed, factor = assumed_factor(channel, rig, where)
    if not heading.unit:
        return assumed, factor
    pair = (assumed, 1.0) if heading.unit.lower() == "db" else frf_unit(reference_of(heading.unit), "")
    if pair is None:
        raise DataError(
            f"column {heading.text!r}: unit {heading.unit!r} is none of an FRF of motion over force",
            where=where,
            remedy="write it as m/s^2/N, m/s/N or m/N, or as dB re 1 m/s^2/N",
        )
    return pair


def _coherence(
    groups: Mapping[tuple[str, int | None], Mapping[Part, Column]],
    outputs: tuple[str, ...],
    points: tuple[int | None, ...],
    where: str,
) -> Real | None:
    if not all("coherence" in parts for parts in groups.values()):
        return None
    columns = [[groups[o, p]["coherence"] for p in points] for o in outputs]
    return np.array([[share_of_one(column.real, where, column.heading.unit) for column in row] for row in columns])
