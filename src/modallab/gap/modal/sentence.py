"""What a comparison with a modal model found, in one sentence."""

from typing import Any

from modallab.core.effects import kind_of
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis


def sentence_by_model(found: ModalDiagnosis) -> str:
    """The verdict, with its numbers."""
    left = f"{found.before:.1%} of the response differs, by {found.strain_before:.2g} deviations of the tolerances"
    if found.verdict == "no_gap":
        return f"No gap beyond the tolerances: {left} (rms; 1 is ordinary)."
    if found.verdict == "unknown":
        return f"A gap that no effect tried explains: {left} (rms; 1 is ordinary)."
    said = " and ".join(_words(effect) for effect in found.effects)
    with_it = f"{found.after:.1%}, by {found.strain_after:.2g}"
    return f"{said[0].upper()}{said[1:]}. Without it {left} (rms; 1 is ordinary); with it {with_it}."


def _words(effect: FoundChange) -> str:
    units = {p.name: p.unit for p in kind_of(effect.effect).parameters}
    numbers = (
        f"{name} {value:.4g} {units.get(name, 'm')}".rstrip() + f" ({low:.4g} to {high:.4g})"
        for (name, value), (low, high) in zip(effect.parameters.items(), effect.interval.values(), strict=True)
        if value or low != high
    )
    place = effect.place
    return (
        f"{effect.effect.replace('_', ' ')} {_where(place)}: {', '.join(numbers)}, probability {effect.probability:.2f}"
    )


def _at(place_m: list[float]) -> str:
    return f"at ({', '.join(f'{x:.3g}' for x in place_m)}) m"


def _where(place: dict[str, Any]) -> str:
    if "channels" in place:
        return "of all channels"
    return f"of {place['channel']}" if "channel" in place else f"near point {place['point']}, {_at(place['at_m'])}"
