"""FRFs of a universal file, with their coherences."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_frequencies
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.formats.frf_file import rising, share_of_one
from modallab.formats.uff.uff_functions import KINDS, FileUnits, Function, UniversalFile
from modallab.formats.uff.uff_lines import axis_of
from modallab.formats.uff.uff_match import divisor_unit_of, known_point, match_channel, sense, unit_of
from modallab.formats.unit_text import frf_unit
from modallab.signals.conversion import sign_of

_Input = tuple[int, int]


@dataclass(frozen=True)
class _Placed:
    function: Function
    output: Channel
    input: _Input
    sign: int


def read_frf(content: UniversalFile, rig: Rig, where: str) -> tuple[Frf, ...]:
    """All FRFs as one matrix in SI units, along the rig's drive; () if there are none.

    Raises:
        DataError: uneven or unequal lines, magnitudes without phase, unknown units, outputs or inputs, or a gap in
            the matrix.
    """
    placed = _place_all(content, 4, rig, where)
    if not placed:
        return ()
    lines = _common_lines([p.function for p in placed.values()], where)
    outputs = [channel for channel in rig.responses if any(p.output.name == channel.name for p in placed.values())]
    inputs = list(dict.fromkeys(p.input for p in placed.values()))
    _check_complete(placed, outputs, inputs, where)
    quantity, values = _scaled(placed, outputs, inputs, content.units, where)
    coherences = _place_all(content, 6, rig, where)
    names = tuple(channel.name for channel in outputs)
    lines, values, coherence = rising(lines, values, _coherence(coherences, outputs, inputs, len(lines), where))
    return (
        Frf(
            frequency_hz=lines,
            values=values,
            quantity=quantity,
            outputs=names,
            output_points=tuple(channel.point for channel in outputs),
            input_points=tuple(known_point(node, rig, where) for node, _ in inputs),
            coherence=coherence,
        ),
    )


def _place_all(content: UniversalFile, kind: int, rig: Rig, where: str) -> dict[tuple[str, _Input], _Placed]:
    placed: dict[tuple[str, _Input], _Placed] = {}
    for function in (f for f in content.functions if f.kind == kind):
        match = match_channel(function, rig.responses, where)
        place = f"{where}, set {function.place}, reference"
        turned = _turned(function, rig, place)
        at = (function.reference_node, abs(function.reference_direction))
        key = (match.channel.name, at)
        if key in placed:
            first = placed[key].function.place
            raise DataError(
                f"sets {first} and {function.place} are both the {KINDS[kind]} of channel {key[0]} to node {at[0]}",
                where=where,
                remedy="leave one of them out",
            )
        placed[key] = _Placed(function, match.channel, at, match.sign * turned * int(sign_of(rig, match.channel)))
    return placed


def _turned(function: Function, rig: Rig, place: str) -> int:
    """1 or -1: a drive along the rig's direction or against it. What is no beam may be driven along any."""
    direction = function.reference_direction
    if rig.model == "unknown" and abs(direction) != axis_of(rig.drive_direction.replace("-", "+")):
        return -1 if direction < 0 else 1
    return sense(direction, rig.drive_direction, place, "drive_direction")


def _common_lines(functions: Sequence[Function], where: str) -> NDArray[np.float64]:
    first = functions[0]
    for function in functions:
        place = f"{where}, set {function.place}"
        check_frequencies(function.axis, place, even=False, resolution_hz=function.axis_error)
        if len(function.axis) != len(first.axis) or not np.allclose(function.axis, first.axis, rtol=1e-6, atol=0):
            raise DataError(
                f"its lines are not those of set {first.place}",
                where=place,
                remedy="export all FRFs over the same frequencies",
            )
    even = np.linspace(first.axis[0], first.axis[-1], len(first.axis))
    return even if np.abs(even - first.axis).max() <= 2 * first.axis_error else first.axis


def _check_complete(
    placed: dict[tuple[str, _Input], _Placed], outputs: Sequence[Channel], inputs: Sequence[_Input], where: str
) -> None:
    gaps = [f"channel {c.name} to node {i[0]}" for c in outputs for i in inputs if (c.name, i) not in placed]
    if gaps:
        raise DataError(
            f"no FRF of {', '.join(gaps)}",
            where=where,
            remedy="export the FRFs of all channels to all inputs, or leave these channels out of the rig",
        )


def _scaled(
    placed: dict[tuple[str, _Input], _Placed],
    outputs: Sequence[Channel],
    inputs: Sequence[_Input],
    units: FileUnits | None,
    where: str,
) -> tuple[FrfQuantity, NDArray[np.complex128]]:
    found = {key: _unit(p.function, units, where) for key, p in placed.items()}
    quantities: set[FrfQuantity] = {quantity for quantity, _ in found.values()}
    if len(quantities) > 1:
        raise DataError(
            f"the FRFs are of several kinds: {', '.join(sorted(quantities))}", where=where, remedy="export them as one"
        )
    values = [
        [found[o.name, i][1] * placed[o.name, i].sign * placed[o.name, i].function.values for i in inputs]
        for o in outputs
    ]
    return quantities.pop(), np.asarray(values, dtype=np.complex128)


def _unit(function: Function, units: FileUnits | None, where: str) -> tuple[FrfQuantity, float]:
    unit, divisor = unit_of(function, units, where), divisor_unit_of(function, units, where)
    # Some programs write the unit of the whole ratio beside the response, and none beside the force.
    found = frf_unit(unit, divisor) or (None if function.divisor_unit else frf_unit(unit, ""))
    if found is None:
        raise DataError(
            f"set {function.place} has the unit {unit or 'none'!r} per {divisor or 'none'!r}, which is no FRF's",
            where=where,
            remedy="export acceleration, velocity or displacement per force, with unit labels",
        )
    return found


def _coherence(
    placed: dict[tuple[str, _Input], _Placed],
    outputs: Iterable[Channel],
    inputs: Sequence[_Input],
    lines: int,
    where: str,
) -> NDArray[np.float64] | None:
    rows = [[placed[o.name, i].function for i in inputs if (o.name, i) in placed] for o in outputs]
    flat = [function for row in rows for function in row]
    if len(flat) != len(rows) * len(inputs) or any(len(function.values) != lines for function in flat):
        return None
    values = np.array([[np.real(function.values) for function in row] for row in rows])
    return share_of_one(values, where)
