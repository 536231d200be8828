"""Learned elements in words, with their numbers and units."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from modallab.core.diagnosis import GapDescription
from modallab.core.digits import percent_text, with_interval
from modallab.core.effect import AllChannels, LearnedElement, OneChannel, x_m_of
from modallab.core.effects import Parameter
from modallab.core.rig import Rig
from modallab.twin.effects import model_of

Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class _Phrase:
    """What a number is called where it is given: `{value}` in its unit here, `{size}` without its sign."""

    number: str
    says: str
    per_unit: float = 1.0
    negative: str = ""


def learned_in_words(learned: Sequence[LearnedElement], rig: Rig) -> str:
    """What they behave like, as the end of a sentence: "a spring of 120 N/m to ground at 0.379 m"."""
    return " and ".join(f"{_PHRASES[one.element](one.parameters)}{_learned_place(one, rig)}" for one in learned)


def numbers_of_description(described: GapDescription) -> tuple[tuple[str, str, str], ...]:
    """A row for each number: its name with the SI unit, its value, its 95 % interval or why there is none."""
    rows = [_row(model_of(e.element).kind.parameter(name), e) for e in described.elements for name in e.parameters]
    if described.x_m is not None:
        rows.append(("place (m from the clamp)", *with_interval(described.x_m, described.x_m_interval)))
    return tuple(rows)


def _row(parameter: Parameter, element: LearnedElement) -> tuple[str, str, str]:
    name = parameter.name
    value, between = with_interval(element.parameters[name], element.interval.get(name))
    why = element.not_known.get(name)
    unit = f" ({parameter.unit})" if parameter.unit else ""
    return f"{parameter.in_words}{unit}", value, f"not known: {why}" if why else between


def _learned_place(one: LearnedElement, rig: Rig) -> str:
    x_m = x_m_of(one.place)
    if x_m is not None:
        return f" at {x_m:.3f} m"
    if isinstance(one.place, AllChannels):
        return " on all accelerometers"
    return f" on {rig.channels[one.place.channel].name}" if isinstance(one.place, OneChannel) else ""


_POINT = (
    _Phrase("hung_m", "a mass of {value:.4g} g on a spring with a resonance of its own at {law[hung_hz]:.4g} Hz", 1e3),
    _Phrase("k", "a spring of {value:.4g} N/m to ground"),
    _Phrase("c", "a damper of {value:.4g} N s/m to ground"),
    _Phrase("m", "a mass of {value:.4g} g", 1e3),
)
_BEAM = (
    _Phrase(
        "tension", "a pull of {size:.4g} N along the beam's axis", 1.0, "a push of {size:.4g} N along the beam's axis"
    ),
    _Phrase("bedding", "a stiffness of {value:.4g} N/m to ground on each metre of the beam"),
)
_SIDE = (
    _Phrase("twist_hz", "modes of twisting, the lowest at {value:.4g} Hz"),
    _Phrase("across_hz", "modes of bending across the drive, the lowest at {value:.4g} Hz"),
    _Phrase("alone_hz", "one mode more at {value:.4g} Hz, largest at the tip"),
)
_FILTER = (
    _Phrase("gain", "a factor of {value:.4g}"),
    _Phrase("delay", "a delay of {value:.4g} ms", 1e3),
    _Phrase("low_pass_hz", "a first-order low-pass at {value:.4g} Hz"),
    _Phrase("high_pass_hz", "a first-order high-pass at {value:.4g} Hz"),
    _Phrase("mount_hz", "a mount with a resonance at {value:.4g} Hz"),
)
_LEVELS_OFF = (
    ("tanh_v", "{:.4g} V"),
    ("knee_v", "{:.4g} V"),
    ("tanh_share", "{:.4g} times each record's own peak"),
    ("knee_share", "{:.4g} times each record's own peak"),
)
_CURVE_TERMS = (("square", 2), ("cubic", 3))


def _joined_phrases(phrases: tuple[_Phrase, ...], law: Numbers) -> str:
    return " and ".join(_phrase_in_words(p, law) for p in phrases if p.number in law)


def _phrase_in_words(phrase: _Phrase, law: Numbers) -> str:
    value = law[phrase.number] * phrase.per_unit
    says = phrase.negative if value < 0 and phrase.negative else phrase.says
    return says.format(value=value, size=abs(value), law=law)


def _curve_in_words(law: Numbers) -> str:
    shape = f", with a knee of power {law['power']:.3g}," if "power" in law else ""
    levels = [says.format(law[name]) for name, says in _LEVELS_OFF if name in law]
    if levels:
        return f"a saturation that levels off at {levels[0]}{shape}"
    terms = " + ".join(f"{law[name]:.3g} u^{power}" for name, power in _CURVE_TERMS if name in law)
    return f"a bent scale, u + {terms} of u in V,"


def _sample_hold_in_words(law: Numbers) -> str:
    instead = "the one before" if law["kept"] else "0"
    return f"a loss of {percent_text(law['share'])} of the samples, with {instead} in their place,"


_PHRASES: dict[str, Callable[[Numbers], str]] = {
    "point_law": partial(_joined_phrases, _POINT),
    "beam_law": partial(_joined_phrases, _BEAM),
    "side_modes": partial(_joined_phrases, _SIDE),
    "row_filter": partial(_joined_phrases, _FILTER),
    "row_curve": _curve_in_words,
    "row_hold": _sample_hold_in_words,
}
