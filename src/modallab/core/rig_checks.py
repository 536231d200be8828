"""What must hold between the fields of a rig, checked as far as the fields themselves are valid."""

from collections.abc import Mapping, Sequence
from typing import Final, cast

from modallab.core.field_errors import (
    INVALID,
    FieldProblem,
    list_entries,
    number_or_none,
    repeated_entries,
    value_in_message,
)
from modallab.core.units import TO_SI

BEAM_RANGES: Final = {
    "length_m": (1e-3, 100.0, "m: 777 mm is 0.777"),
    "width_m": (1e-5, 10.0, "m: 50 mm is 0.05"),
    "thickness_m": (1e-6, 1.0, "m: 4 mm is 0.004"),
    "youngs_modulus_pa": (1e6, 1e13, "Pa: 205 GPa is 2.05e11"),
    "density_kg_m3": (1.0, 1e5, "kg/m^3: 7.85 g/cm^3 is 7850"),
}
"""What a beam on a bench can be; beyond these ranges a number is in another unit."""

_ROUNDING = 1e-9


def inconsistent_fields(content: Mapping[str, object]) -> list[FieldProblem]:
    """Everything wrong between the fields of a rig.

    Args:
        content: the rig as plain lists and mappings, with `INVALID` for each field that is wrong on its own.
    """
    points, channels = list_entries(content, "points"), list_entries(content, "channels")
    problems = [*_beam_problems(content), *_point_problems(content, points)]
    for place, channel in enumerate(channels):
        problems += channel_problems(channel, f"channels[{place}].")
    needs_force = content.get("model", "cantilever") != "unknown"
    return [
        *problems,
        *_drawn_problems(content, points, "lines", "two point numbers of this rig"),
        *_drawn_problems(content, points, "surfaces", "three or more ids of points of this rig"),
        *_channel_set_problems(channels, list_entries(content, "shakers"), needs_force=needs_force),
        *_reference_problems(content, points, channels),
        *shaker_problems(content, channels, list_entries(content, "shakers")),
    ]


def channel_problems(channel: Mapping[str, object], prefix: str = "") -> list[FieldProblem]:
    """What is wrong between the fields of one channel."""
    problems: list[FieldProblem] = []
    quantity, unit = channel.get("quantity"), channel.get("unit")
    if isinstance(quantity, str) and isinstance(unit, str) and quantity in TO_SI:
        units = TO_SI[quantity]
        if unit not in units:
            problems.append(
                FieldProblem(f"{prefix}unit", f"found {unit!r}", f"{', '.join(units)} (units of {quantity})")
            )
    value = channel.get("sensitivity_v_per_unit", 1.0)
    named = cast("Mapping[object, object]", value).items() if isinstance(value, Mapping) else (("", value),)
    for test, stated in named:
        if number_or_none(stated) == 0:
            field = f"{prefix}sensitivity_v_per_unit{f'.{test}' if test else ''}"
            problems.append(FieldProblem(field, f"found {stated}", "any number but 0 (negative for a turned sensor)"))
    return problems


def _beam_problems(content: Mapping[str, object]) -> list[FieldProblem]:
    beam = content.get("beam")
    if content.get("model", "cantilever") == "cantilever" and beam is None:
        return [FieldProblem("beam", "missing", "a beam, or model: unknown")]
    if not isinstance(beam, Mapping):
        return []
    fields = cast("Mapping[str, object]", beam)
    return [
        FieldProblem(f"beam.{name}", f"found {value:g}", f"{low:g} to {high:g} {unit}")
        for name, (low, high, unit) in BEAM_RANGES.items()
        if (value := number_or_none(fields.get(name))) is not None and not low <= value <= high
    ]


def _point_problems(content: Mapping[str, object], points: Sequence[Mapping[str, object]]) -> list[FieldProblem]:
    problems = repeated_entries("points", "id", [number_or_none(point.get("id")) for point in points])
    beam = content.get("beam")
    length = number_or_none(cast("Mapping[str, object]", beam).get("length_m")) if isinstance(beam, Mapping) else None
    for place, point in enumerate(points):
        x = number_or_none(point.get("x_m"))
        if x is not None and length is not None and not 0 <= x <= length * (1 + _ROUNDING):
            problems.append(FieldProblem(f"points[{place}].x_m", f"found {x:g}", f"0 to beam.length_m = {length:g}"))
    return problems


def _drawn_problems(
    content: Mapping[str, object], points: Sequence[Mapping[str, object]], what: str, allowed: str
) -> list[FieldProblem]:
    """Lines or surfaces between points that are none."""
    drawn, ids = content.get(what), [number_or_none(point.get("id")) for point in points]
    if not isinstance(drawn, Sequence) or isinstance(drawn, str) or None in ids:
        return []
    named = [(n, cast("Sequence[object]", ends)) for n, ends in enumerate(cast("Sequence[object]", drawn))]
    return [
        FieldProblem(f"{what}[{n}]", f"found {end}", allowed)
        for n, ends in named
        if isinstance(ends, Sequence) and not isinstance(ends, str)
        for end in ends
        if number_or_none(end) is not None and number_or_none(end) not in ids
    ]


def _channel_set_problems(
    channels: Sequence[Mapping[str, object]], shakers: Sequence[Mapping[str, object]], *, needs_force: bool
) -> list[FieldProblem]:
    names = [channel.get("name") for channel in channels]
    problems = repeated_entries("channels", "name", [name if isinstance(name, str) else None for name in names])
    inputs = [channel.get("input") for channel in channels]
    problems += repeated_entries(
        "channels", "input", [name if isinstance(name, str) and name else None for name in inputs]
    )
    for place, channel in enumerate(channels):
        index = number_or_none(channel.get("index"))
        if index is not None and index != place:
            problems.append(
                FieldProblem(
                    f"channels[{place}].index", f"found {index:g}", f"{place}: channels stand in order 0, 1, 2, ..."
                )
            )
    quantities = [channel.get("quantity", INVALID) for channel in channels]
    forces = [place for place, quantity in enumerate(quantities) if quantity == "force"]
    absent = needs_force and not forces and INVALID not in quantities
    most = 1 + len(shakers)
    if channels and (len(forces) > most or absent or len(forces) == len(channels)):
        found = "quantity: force at " + ", ".join(f"channels[{i}]" for i in forces) if forces else "no quantity: force"
        allowed = f"{'exactly' if needs_force else 'at most'} one channel of quantity force"
        allowed += f" beside those of the {len(shakers)} under shakers" if shakers else ""
        if len(forces) > most:
            allowed += ", with an entry under shakers for each further one"
        problems.append(FieldProblem("channels", found, f"{allowed}, and a response"))
    return problems


def _reference_problems(
    content: Mapping[str, object], points: Sequence[Mapping[str, object]], channels: Sequence[Mapping[str, object]]
) -> list[FieldProblem]:
    ids = [number_or_none(point.get("id")) for point in points]
    if None in ids or content.get("points") is INVALID:
        return []
    named = [(f"channels[{place}].point", channel.get("point")) for place, channel in enumerate(channels)]
    allowed = "the id of a point of this rig" + (
        f": {', '.join(f'{i:g}' for i in ids if i is not None)}" if ids else ""
    )
    return [
        FieldProblem(field, f"found {value}", allowed)
        for field, value in [*named, ("shaker_point", content.get("shaker_point")), *_shaker_points(content)]
        if number_or_none(value) is not None and number_or_none(value) not in ids
    ]


def _shaker_points(content: Mapping[str, object]) -> list[tuple[str, object]]:
    return [(f"shakers[{place}].point", s.get("point")) for place, s in enumerate(list_entries(content, "shakers"))]


def shaker_problems(
    content: Mapping[str, object], channels: Sequence[Mapping[str, object]], shakers: Sequence[Mapping[str, object]]
) -> list[FieldProblem]:
    """What is wrong between the shakers beside the first one and the rest of the rig."""
    if not shakers:
        return []
    problems: list[FieldProblem] = []
    first = content.get("shaker_point")
    if first is None:
        problems.append(
            FieldProblem("shaker_point", "missing", "the point of the first shaker, where others are listed")
        )
    points = [number_or_none(first), *(number_or_none(shaker.get("point")) for shaker in shakers)]
    excitation = content.get("excitation")
    wired = cast("Mapping[str, object]", excitation).get("output") if isinstance(excitation, Mapping) else ""
    problems += _repeated_of_shakers("point", points)
    problems += _repeated_of_shakers("output", [_text(wired), *(_text(shaker.get("output")) for shaker in shakers)])
    problems += _repeated_of_shakers("force", [None, *(_text(shaker.get("force")) for shaker in shakers)])
    return problems + _force_channel_problems(channels, shakers)


def _force_channel_problems(
    channels: Sequence[Mapping[str, object]], shakers: Sequence[Mapping[str, object]]
) -> list[FieldProblem]:
    if any(channel.get("quantity", INVALID) is INVALID or channel.get("name") is INVALID for channel in channels):
        return []
    forces = [channel.get("name") for channel in channels if channel.get("quantity") == "force"]
    named = [shaker.get("force") for shaker in shakers]
    problems = [
        FieldProblem(f"shakers[{place}].force", f"found {name!r}", f"the name of a channel of quantity force: {forces}")
        for place, name in enumerate(named)
        if isinstance(name, str) and name not in forces
    ]
    if not problems and forces and all(name in named for name in forces):
        problems.append(
            FieldProblem(
                "shakers", f"all force channels, {forces}", "one force channel without a shaker, for the first shaker"
            )
        )
    return problems


def _repeated_of_shakers(field: str, values: Sequence[str | float | None]) -> list[FieldProblem]:
    """Values of the first shaker and of those listed that occur twice; None: not known."""
    return [
        FieldProblem(
            f"shakers[{place - 1}].{field}", f"found {value_in_message(value)}, which another shaker has", "each once"
        )
        for place, value in enumerate(values)
        if value is not None and values.index(value) < place
    ]


def _text(value: object) -> str | None:
    return value if isinstance(value, str) and value else None
