"""An effect in words: its name, its numbers and its place, on a beam and on a measured structure."""

from collections.abc import Mapping, Sequence
from typing import cast

from modallab.core.diagnosis import Found
from modallab.core.digits import listed, probability, rough, with_interval
from modallab.core.effects import Parameter, kind_of
from modallab.core.modal_diagnosis import FoundChange
from modallab.twin.effects import model_of

FIXED = {
    "root": "at the clamp",
    "shaker": "at the shaker",
    "base": "at the base",
    "force": "on the force channel",
    "hit": "where the hammer strikes",
    "impact": "in the impact test",
}
"""Places that an effect always has."""
FROM_CLAMP = " from the clamp"
OPEN = 100.0
"""End of an interval over its beginning, from which a number is not known to within a factor of ten."""


def named(effects: Sequence[str]) -> str:
    """Effects of the catalogue: "added mass and loose clamp"."""
    return listed([model_of(name).spoken for name in effects])


def spoken(found: Found, channels: Sequence[str] = ()) -> str:
    """An effect with its place, its numbers and its probability; channels by number where their names are not given."""
    numbers = [_with_value(found, p) for p in kind_of(found.effect).parameters]
    beside = "; ".join([*([", ".join(numbers)] if numbers else []), f"probability {probability(found.probability)}"])
    return f"{' '.join(filter(None, (model_of(found.effect).spoken, at(found, channels))))} ({beside})"


def _with_value(found: Found, parameter: Parameter) -> str:
    if parameter.name in found.not_known:
        return f"{parameter.name} not known"
    return f"{parameter.name} = {of_parameter(found, parameter)[0]}"


def of_parameter(found: Found, parameter: Parameter) -> tuple[str, str]:
    """A parameter's value and its interval; why it has none, where the records leave it open."""
    why = found.not_known.get(parameter.name)
    if why:
        return f"about {rough(found.parameters[parameter.name])} {parameter.unit}".rstrip(), f"not known: {why}"
    return with_interval(found.parameters[parameter.name], found.interval.get(parameter.name), parameter.unit)


def at(found: Found, channels: Sequence[str] = ()) -> str:
    """Where an effect acts, within a sentence: "at 0.622 m", "on a03 and a07"; "" where it has one place only."""
    place = place_of(found, channels)[0]
    if place in FIXED.values() or found.place.get("channel") == "all":
        return ""
    return f"at {place.removesuffix(FROM_CLAMP)}" if place.endswith(FROM_CLAMP) else place


def place_of(found: Found, channels: Sequence[str] = ()) -> tuple[str, str]:
    """Where an effect acts, and its 95 % interval: "0.622 m from the clamp", "0.621 to 0.623 m"; "" for all of it."""
    x_m, channel = found.place.get("x_m"), found.place.get("channel")
    if "x" in found.not_known:
        return "somewhere along the beam", f"not known: {found.not_known['x']}"
    if isinstance(x_m, float):
        value, interval = with_interval(x_m, interval_m(found), "m")
        return f"{value}{FROM_CLAMP}", interval
    if channel == "all":
        return "on all channels", ""
    if channel is not None:
        return _on(channel, channels), ""
    return FIXED.get(kind_of(found.effect).place, ""), ""


def interval_m(found: Found) -> tuple[float, float] | None:
    """The 95 % interval of a place along the beam, in m from the clamp."""
    x, x_m, share = found.place.get("x"), found.place.get("x_m"), found.interval.get("x")
    if share is None or not isinstance(x_m, float):
        return None
    length = x_m / x if isinstance(x, float) and x else 1.0
    return share[0] * length, share[1] * length


def _on(channel: object, channels: Sequence[str]) -> str:
    rows = cast("Sequence[object]", channel) if isinstance(channel, list | tuple) else [channel]
    names = [channels[row] for row in rows if isinstance(row, int) and 0 <= row < len(channels)]
    if len(names) == len(rows):
        return f"on {listed(names)}"
    return f"on channel{'s' * (len(rows) > 1)} {listed([str(row) for row in rows])}"


def spoken_change(change: FoundChange) -> str:
    """An effect on a measured structure, with its place: "added mass near point 12"."""
    return f"{model_of(change.effect).spoken} {place_of_change(change)}"


def with_numbers(change: FoundChange) -> str:
    """The same with its numbers, their intervals and its probability."""
    numbers = (f"{name} = {value} ({interval})" for name, value, interval in numbers_of(change))
    return f"{spoken_change(change)}: {', '.join(numbers)}, probability {probability(change.probability)}"


def place_of_change(change: FoundChange) -> str:
    """On a channel, or near a point; of a spring with the axis along which it pulls."""
    place = cast("Mapping[str, object]", change.place)
    if "channels" in place:
        return "of all channels"
    if "channel" in place:
        return f"of {place['channel']}" if change.effect == "position_error" else f"on {place['channel']}"
    along = f", along {place['axis']}" if "axis" in place else ""
    return f"near point {place['point']}{along}"


def at_of_change(change: FoundChange) -> tuple[float, float, float] | None:
    """x, y and z in m where a change hangs on the structure; None where it is a channel's."""
    at_m = change.place.get("at_m")
    return None if at_m is None else cast("tuple[float, float, float]", tuple(at_m))


def numbers_of(change: FoundChange) -> list[tuple[str, str, str]]:
    """Name, value and 95 % interval of each number; a direction in which a sensor cannot be moved is left out."""
    units = {p.name: p.unit for p in kind_of(change.effect).parameters}
    return [
        (name, *_of_change(value, change.interval[name], units.get(name, "m")))
        for name, value in change.parameters.items()
        if value or len(set(change.interval[name])) > 1
    ]


def _of_change(value: float, interval: tuple[float, float], unit: str) -> tuple[str, str]:
    low, high = interval
    if low > 0 and high > OPEN * low:
        return f"about {rough(value)} {unit}", "not known: the records leave it open"
    return with_interval(value, interval, unit)
