"""An effect in words: its name, its numbers and its place, on a beam and on a measured structure."""

from collections.abc import Sequence

from modallab.core.diagnosis import FoundEffect
from modallab.core.digits import list_in_words, one_digit, probability_text, with_interval
from modallab.core.effect import (
    AllChannels,
    AlongBeam,
    BetweenPoints,
    EveryOutput,
    NamedChannel,
    NearPoint,
    channels_of_place,
    x_m_of,
)
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
"""Places that need no words: the effect is never anywhere else."""
FROM_CLAMP = " from the clamp"
OFFSETS = ("dx", "dy", "dz")
"""Numbers of a sensor that moved along a surface."""
OPEN = 100.0
"""End of an interval over its beginning, from which a number is not known to within a factor of ten."""


def effect_names(effects: Sequence[str]) -> str:
    """Effects of the catalogue: "added mass and loose clamp"."""
    return list_in_words([model_of(name).spoken for name in effects])


def effect_in_words(found: FoundEffect, channels: Sequence[str] = ()) -> str:
    """An effect with its place, its numbers and its probability; channels by number where their names are not given."""
    numbers = [_with_value(found, p) for p in kind_of(found.effect).parameters]
    beside = "; ".join([*numbers, f"probability {probability_text(found.probability)}"])
    return f"{' '.join(filter(None, (model_of(found.effect).spoken, place_in_words(found, channels))))} ({beside})"


def _with_value(found: FoundEffect, parameter: Parameter) -> str:
    if parameter.name in found.not_known:
        return f"{parameter.in_words} not known"
    value, interval = parameter_in_words(found, parameter)
    return f"{parameter.in_words} {value}{f', 95 %: {interval}' if interval else ''}"


def parameter_in_words(found: FoundEffect, parameter: Parameter) -> tuple[str, str]:
    """A parameter's value and its interval; why it has none, where the records leave it open."""
    why = found.not_known.get(parameter.name)
    if why:
        return f"about {one_digit(found.parameters[parameter.name])} {parameter.unit}".rstrip(), f"not known: {why}"
    return with_interval(found.parameters[parameter.name], found.interval.get(parameter.name), parameter.unit)


def place_in_words(found: FoundEffect, channels: Sequence[str] = ()) -> str:
    """Where an effect acts, within a sentence: "at 0.622 m", "on a03 and a07"; "" where it has one place only."""
    place = place_of(found, channels)[0]
    if place in FIXED.values() or isinstance(found.place, AllChannels):
        return ""
    return f"at {place.removesuffix(FROM_CLAMP)}" if place.endswith(FROM_CLAMP) else place


def place_of(found: FoundEffect, channels: Sequence[str] = ()) -> tuple[str, str]:
    """Where an effect acts, and its 95 % interval: "0.622 m from the clamp", "0.621 to 0.623 m"; "" for all of it."""
    x_m, rows = x_m_of(found.place), channels_of_place(found.place)
    if "x" in found.not_known:
        return "somewhere along the beam", f"not known: {found.not_known['x']}"
    if x_m is not None:
        value, interval = with_interval(x_m, interval_m(found), "m")
        return f"{value}{FROM_CLAMP}", interval
    if rows == "all":
        return "on all channels", ""
    if rows is not None:
        return _channel_in_words(rows, channels), ""
    return FIXED.get(kind_of(found.effect).place, ""), ""


def interval_m(found: FoundEffect) -> tuple[float, float] | None:
    """The 95 % interval of a place along the beam, in m from the clamp."""
    place, share = found.place, found.interval.get("x")
    if share is None or not isinstance(place, AlongBeam) or place.x_m is None:
        return None
    length = place.x_m / place.x if place.x else 1.0
    return share[0] * length, share[1] * length


def _channel_in_words(channel: int | tuple[int, int], channels: Sequence[str]) -> str:
    rows = (channel,) if isinstance(channel, int) else channel
    names = [channels[row] for row in rows if 0 <= row < len(channels)]
    if len(names) == len(rows):
        return f"on {list_in_words(names)}"
    return f"on channel{'s' * (len(rows) > 1)} {list_in_words([str(row) for row in rows])}"


def effect_phrase(change: FoundChange) -> str:
    """An effect on a measured structure: "added mass"; a spring between two points has no part in the ground."""
    spoken = model_of(change.effect).spoken
    return spoken.removeprefix("ground ") if isinstance(change.place, BetweenPoints) else spoken


def change_with_place(change: FoundChange) -> str:
    """The same with its place: "added mass near point 12"."""
    return f"{effect_phrase(change)} {place_of_change(change)}"


def effect_with_numbers(change: FoundChange) -> str:
    """The same with its numbers, their intervals and its probability."""
    numbers = (f"{name} {value} ({interval})" for name, value, interval in numbers_of(change))
    return f"{change_with_place(change)}: {', '.join(numbers)}, probability {probability_text(change.probability)}"


def place_of_change(change: FoundChange) -> str:
    """On a channel, or near a point; of a spring with the axis along which it pulls."""
    place = change.place
    if isinstance(place, EveryOutput):
        return "of all channels"
    if isinstance(place, NamedChannel):
        return f"{'of' if change.effect == 'position_error' else 'on'} {place.channel}"
    if isinstance(place, BetweenPoints):
        return f"between points {place.points[0]} and {place.points[1]}, along {place.axis}"
    return f"near point {place.point}" + (f", along {place.axis}" if place.axis else "")


def position_of_change(change: FoundChange) -> tuple[float, float, float] | None:
    """x, y and z in m where a change hangs on the structure; None where it is a channel's."""
    return change.place.at_m if isinstance(change.place, NearPoint | BetweenPoints) else None


def numbers_of(change: FoundChange) -> list[tuple[str, str, str]]:
    """Name, value and 95 % interval of each number; a direction in which a sensor cannot be moved is left out."""
    kind = kind_of(change.effect)
    known = {p.name: p for p in (*kind.parameters, kind.at_points) if p is not None}
    return [
        (
            f"offset along {name[1]}" if name in OFFSETS else known[name].in_words,
            *_change_in_words(value, change.interval[name], known[name].unit if name in known else "m"),
        )
        for name, value in change.parameters.items()
        if value or len(set(change.interval[name])) > 1
    ]


def _change_in_words(value: float, interval: tuple[float, float], unit: str) -> tuple[str, str]:
    low, high = interval
    if low > 0 and high > OPEN * low:
        return f"about {one_digit(value)} {unit}", "not known from the records"
    return with_interval(value, interval, unit)
