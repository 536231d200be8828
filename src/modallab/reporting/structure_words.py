"""Changes of a structure in words, with as many digits as their intervals bear."""

from collections.abc import Mapping
from typing import cast

from modallab.core.effects import kind_of
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis
from modallab.reporting.gap_words import in_between, percent, sure
from modallab.twin.effects import model_of

OPEN = 100.0
"""End of an interval over its beginning, from which a number is not known to within a factor of ten."""


def sentence_by_model(found: ModalDiagnosis) -> str:
    """The verdict of a comparison with a modal model, with its probability."""
    before = f"{percent(found.before)} of the response differs"
    differs = f"{before}, by {found.strain_before:.2g} deviations of the tolerances"
    if found.verdict == "no_gap":
        return f"No gap beyond the tolerances{_probable(found.nothing)}: {differs} (rms; 1 is ordinary)."
    if found.verdict == "unknown":
        gap = f"A gap that no effect of the catalogue explains{_probable(found.unknown)}"
        return f"{gap}: {differs} (rms; 1 is ordinary)."
    said = " and ".join(_with_numbers(change) for change in found.effects)
    left = f"{percent(found.after)}, by {found.strain_after:.2g}"
    return f"{said[0].upper()}{said[1:]}. Without it {differs} (rms; 1 is ordinary); with it {left}."


def _probable(probability: float | None) -> str:
    """Files of earlier versions state none."""
    return "" if probability is None else f", probability {sure(probability)}"


def _with_numbers(change: FoundChange) -> str:
    numbers = (f"{name} = {value} ({interval})" for name, value, interval in numbers_of(change))
    return f"{spoken(change)}: {', '.join(numbers)}, probability {sure(change.probability)}"


def spoken(change: FoundChange) -> str:
    """An effect of the catalogue by its name, with its place: "added mass near point 12"."""
    return f"{model_of(change.effect).spoken} {place_of_change(change)}"


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
    at = change.place.get("at_m")
    return None if at is None else cast("tuple[float, float, float]", tuple(at))


def numbers_of(change: FoundChange) -> list[tuple[str, str, str]]:
    """Name, value and 95 % interval of each number; a direction in which a sensor cannot be moved is left out."""
    units = {p.name: p.unit for p in kind_of(change.effect).parameters}
    return [
        (name, *_between(value, change.interval[name], units.get(name, "m")))
        for name, value in change.parameters.items()
        if value or len(set(change.interval[name])) > 1
    ]


def _between(value: float, interval: tuple[float, float], unit: str) -> tuple[str, str]:
    low, high = interval
    if low > 0 and high > OPEN * low:
        return f"about {_rough(value)} {unit}", "not known: the records leave it open"
    return in_between(value, interval, unit)


def _rough(value: float) -> str:
    """To one digit."""
    return f"{float(f'{value:.1g}'):.15g}"
