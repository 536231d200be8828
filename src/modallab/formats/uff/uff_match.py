"""Which channel of the rig a function of a universal file belongs to, and in which sense."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import SI_UNIT, TO_SI, Quantity
from modallab.formats.uff.uff_functions import FileUnits, Function
from modallab.formats.unit_text import quantity_of

SPECIFIC: dict[int, Quantity] = {
    8: "displacement",
    9: "force",
    11: "velocity",
    12: "acceleration",
    13: "force",
    15: "pressure",
}
"""What the format's specific data types mean."""

_AXES = "xyz"
_LBF, _KGF = 1 / TO_SI["force"]["lbf"], 1 / TO_SI["force"]["kgf"]
_SYSTEMS = {2: (1 / 0.3048, _LBF), 3: (1.0, _KGF), 5: (1e3, 1e3), 6: (1e2, 1e2), 7: (1 / 0.0254, _LBF)}
_SYSTEMS |= {8: (1e3, _KGF), 10: (1e3, 1.0)}
"""What the format's codes stand for: its units of length to a metre, and of force to a newton."""
_OWN = 9
"""The code of units that only the factors say."""
_SAME_UNIT = 1e-4
"""Relative: factors are written with few digits, and units differ by more."""


@dataclass(frozen=True)
class Match:
    """A channel, and the sign that turns the function's sense into the channel's."""

    channel: Channel
    sign: int


def match_channel(function: Function, candidates: Sequence[Channel], where: str) -> Match:
    """The channel of a function: the one of the same name, else at the same node and axis, else alone of its kind.

    Of several at one place it is the one that measures what the function is of, as a force and an acceleration.

    Raises:
        DataError: no channel or several fit, or the direction is not the channel's.
    """
    names = {name.casefold() for name in function.names}
    by_unit = quantity_of(function.unit)
    quantity = SPECIFIC.get(function.specific, by_unit) if by_unit in (None, "voltage") else by_unit
    there = [c for c in candidates if function.node and c.point == function.node and _same_axis(function.direction, c)]
    groups = (
        [c for c in candidates if c.name.casefold() in names],
        [c for c in candidates if quantity == "force" == c.quantity],
        [c for c in there if c.quantity == quantity],
        there,
        [c for c in candidates if c.quantity == quantity and all(other.point is None for other in candidates)],
    )
    found = next((group[0] for group in groups if len(group) == 1), None)
    if found is None:
        known = ", ".join(f"{c.name} (point {c.point}, {c.direction})" for c in candidates)
        raise DataError(
            f"set {function.place}, {_place_of(function)}, is no single channel of the rig; it has {known}",
            where=where,
            remedy="give the rig's channel this point and direction, or the set the channel's name",
        )
    field = f"the direction of channel {found.name}"
    return Match(found, sense(function.direction, found.direction, f"{where}, set {function.place}", field))


def sense(direction: int, own: str, where: str, field: str) -> int:
    """1 or -1: whether a direction of the format has the sense of one of the rig, such as "+z".

    Args:
        direction: 1, 2, 3 for x, y, z, negative for the other sense; 0 if unknown.
        own: direction in the rig.
        where: file and set.
        field: of the rig file that says the rig's direction.

    Raises:
        DataError: another axis, or a rotation.
    """
    if direction == 0:
        return 1
    if abs(direction) > len(_AXES) or _AXES[abs(direction) - 1] != own[1]:
        raise DataError(
            f"direction {_direction(direction)} is not that of the rig, {own}",
            where=where,
            remedy=f"set {field} in the rig file to {_direction(direction)}, or leave this set out",
        )
    return 1 if (direction > 0) == (own[0] == "+") else -1


def known_point(node: int, rig: Rig, where: str) -> int | None:
    """The point of a node; None if the node is unknown or the rig has no points.

    Raises:
        DataError: the rig has points, but not this one.
    """
    points = [point.id for point in rig.points]
    if node == 0 or not points:
        return None
    if node not in points:
        raise DataError(
            f"node {node} is no point of the rig, which has {', '.join(map(str, points))}",
            where=where,
            remedy="add the point to the rig file",
        )
    return node


def unit_of(function: Function, units: FileUnits | None, where: str) -> str:
    """Unit of a function's ordinate: its label, else the file's unit of what it is; "" if it says neither.

    Raises:
        DataError: no label, and the file's units are none that is known.
    """
    return _unit(function, function.unit, function.specific, units, where)


def divisor_unit_of(function: Function, units: FileUnits | None, where: str) -> str:
    """The same for the denominator."""
    return _unit(function, function.divisor_unit, function.divisor_specific, units, where)


def _unit(function: Function, label: str, specific: int, units: FileUnits | None, where: str) -> str:
    if label or specific not in SPECIFIC:
        return label
    quantity = SPECIFIC[specific]
    if units is None or units.code == 1:
        return SI_UNIT[quantity]
    parts = {"force": units.force, "pressure": units.force / units.length**2}
    to_si = 1.0 / parts.get(quantity, units.length)
    fitting = [unit for unit, factor in TO_SI[quantity].items() if math.isclose(factor, to_si, rel_tol=_SAME_UNIT)]
    if not (fitting and _agree(units)):
        raise DataError(
            f"set {function.place} has no unit label, and dataset 164 says no unit of {quantity}: code {units.code}, "
            f"{units.length:g} to a metre, {units.force:g} to a newton",
            where=where,
            remedy="export the file again with unit labels, or in SI units",
        )
    return fitting[0]


def _agree(units: FileUnits) -> bool:
    """Whether the factors are those of the code; programs have written factors that contradict it."""
    if units.code == _OWN:
        return True
    meant = _SYSTEMS.get(units.code, (0.0, 0.0))
    return all(math.isclose(a, b, rel_tol=_SAME_UNIT) for a, b in zip(meant, (units.length, units.force), strict=True))


def _same_axis(direction: int, channel: Channel) -> bool:
    return direction == 0 or (abs(direction) <= len(_AXES) and _AXES[abs(direction) - 1] == channel.direction[1])


def _place_of(function: Function) -> str:
    node = f"node {function.node} {_direction(function.direction)}" if function.node else "without a node"
    unit = f" in {function.unit!r}" if function.unit else ""
    return f"{function.names[1] or function.names[0]!r}{unit}, {node}"


def _direction(direction: int) -> str:
    sign = "-" if direction < 0 else "+"
    if direction == 0:
        return "without a direction"
    kind = "" if abs(direction) <= len(_AXES) else "rotation about "
    return f"{kind}{sign}{_AXES[(abs(direction) - 1) % len(_AXES)]}"
