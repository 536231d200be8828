"""The effects of one bench: read as they stand in its address, checked against its rig, reported as text."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite

from modallab.core.effect import AlongBeam, NoPlace, OneChannel, Place, TwoChannels, channels_of_place
from modallab.core.effects import Effect, EffectKind
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart
from modallab_simulators.cantilever.effects import allowed_range, effect_parts, kinds, part_of


def read_effect(text: str) -> tuple[Effect | None, list[str]]:
    """The effect a text describes, and everything that is wrong with the text; None if anything is."""
    name, *words = [word.strip() for word in text.split(",")]
    known = kinds()
    if name not in known:
        return None, [f"no effect is called {name!r}; allowed: {', '.join(sorted(known))}"]
    part, kind, problems = part_of(name), known[name], list[str]()
    given = _pairs(name, words, problems)
    place = _place(kind, given, problems)
    parameters = _parameters(part, given, problems)
    if problems:
        return None, problems
    return Effect(effect=name, parameters=parameters, place=place), []


def _pairs(name: str, words: list[str], problems: list[str]) -> dict[str, str]:
    given: dict[str, str] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals or not key or not value:
            problems.append(f"{name}: cannot read {word!r}; allowed: name=value")
        elif key in given:
            problems.append(f"{name}: {key} occurs twice; allowed: once")
        else:
            # A plus sign arrives from an address as a blank.
            given[key] = value.replace(" ", "+")
    return given


def _parameters(part: EffectPart, given: dict[str, str], problems: list[str]) -> dict[str, float]:
    kind, optional = part.kind, part.options
    names = [p.name for p in kind.parameters]
    parameters: dict[str, float] = {}
    for name in (*names, *optional):
        text = given.pop(name, None)
        if text is None:
            if name in names:
                problems.append(f"{kind.name}: {name} is missing; allowed: {_range(part, name)}")
            continue
        value = _number(text)
        low, high = allowed_range(part, name)
        if value is None or not low <= value <= high or value == 0.0:
            problems.append(f"{kind.name}: {name} is {text!r}; allowed: {_range(part, name)}")
        else:
            parameters[name] = value
    problems += [
        f"{kind.name} has no parameter {key!r}; allowed: {', '.join((*names, *optional)) or 'none'}" for key in given
    ]
    return parameters


def _place(kind: EffectKind, given: dict[str, str], problems: list[str]) -> Place:
    fixed = NoPlace() if kind.place == "shaker" else kind.fixed_place
    if fixed is not None:
        return fixed
    if kind.place == "x":
        text = given.pop("x", "")
        x = _number(text)
        if x is None or not 0 < x <= 1:
            problems.append(
                f"{kind.name}: x is {repr(text) if text else 'missing'}; "
                "allowed: above 0 to 1, a share of the length from the clamp"
            )
            return NoPlace()
        return AlongBeam(x=x)
    text = given.pop("channel", "")
    channels = [_channel(part) for part in text.split(":")]
    needed = 2 if kind.place == "pair" else 1
    if len(channels) != needed or None in channels or len(set(channels)) != needed:
        form = "two accelerometers, such as a03:a07" if needed == 2 else "one accelerometer, such as a03"
        problems.append(f"{kind.name}: channel is {repr(text) if text else 'missing'}; allowed: {form}")
        return NoPlace()
    numbers = [c for c in channels if c is not None]
    return TwoChannels(channel=(numbers[0], numbers[1])) if needed == 2 else OneChannel(channel=numbers[0])


def _channel(text: str) -> int | None:
    digits = text.removeprefix("a")
    return int(digits) if digits.isascii() and digits.isdigit() and int(digits) > 0 else None


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None


def _range(part: EffectPart, name: str) -> str:
    low, high = allowed_range(part, name)
    unit = next((p.unit for p in part.kind.parameters if p.name == name), "")
    if low == high:
        return f"{low:g}"
    side = {(True, True): "any number but 0"}.get((isfinite(low), isfinite(high)))
    side = f"{low:g} to {high:g}, not 0" if isfinite(low) and isfinite(high) else side
    side = side or ("above 0" if isfinite(low) else "any number but 0")
    return f"{side} {unit}".strip()


@dataclass(frozen=True, slots=True)
class InjectedEffects:
    """All effects of a bench, in the order they were given, and the bench as they leave it."""

    effects: tuple[Effect, ...] = ()
    altered: AlteredBench = field(default_factory=AlteredBench)

    def reported(self) -> str:
        """As JSON, in the form of a campaign's truth: effect, family, parameters, place."""
        return json.dumps([effect_in_truth(e) for e in self.effects])


def effect_in_truth(effect: Effect) -> dict[str, object]:
    """An effect as a campaign's truth reports it."""
    part = part_of(effect.effect)
    return {
        "effect": effect.effect,
        "family": part.kind.stage,
        "parameters": {k: v for k, v in effect.parameters.items() if k not in part.options},
        "place": effect.place.model_dump(mode="json"),
    }


def inject_effects(effects: Sequence[Effect], rig: Rig) -> InjectedEffects:
    """Place effects on a rig.

    Raises:
        ConfigurationError: the rig has no such channel, no shaker, no room; one that stands for itself occurs twice.
    """
    problems: list[str] = []
    placed = tuple(_at_shaker(e, rig, problems) for e in effects)
    if sum(part_of(e.effect).joint for e in placed) > 1:
        joints = " and ".join(name for name, part in effect_parts().items() if part.joint)
        problems.append(f"{joints} are both the joint at the root; allowed: one of them")
    for place, effect in enumerate(placed):
        problems += _channel_problems(effect, rig) or part_of(effect.effect).check(effect, rig)
        problems += _repeated(effect, placed[:place])
    if problems:
        raise ConfigurationError("\n".join(problems), remedy="correct the effects in the bench's address")
    altered = AlteredBench()
    for effect in sorted(placed, key=lambda e: part_of(e.effect).rank):
        altered = part_of(effect.effect).change(altered, effect, rig)
    return InjectedEffects(placed, altered)


def _at_shaker(effect: Effect, rig: Rig, problems: list[str]) -> Effect:
    if part_of(effect.effect).kind.place != "shaker":
        return effect
    if rig.shaker_point is None or rig.beam is None:
        problems.append(f"{effect.effect}: the rig has no shaker")
        return effect
    return effect.model_copy(update={"place": AlongBeam(x=rig.x_of(rig.shaker_point) / rig.beam.length_m)})


def _channel_problems(effect: Effect, rig: Rig) -> list[str]:
    rows = channels_of_place(effect.place)
    found: list[str] = []
    for row in rows if isinstance(rows, tuple) else (rows,):
        if not isinstance(row, int) or part_of(effect.effect).kind.place == "force":
            continue
        if row >= len(rig.channels) or rig.channels[row].quantity == "force":
            names = ", ".join(c.name for c in rig.responses)
            found.append(f"{effect.effect}: channel {row} is no accelerometer of the rig; allowed: {names}")
    return found


def _repeated(effect: Effect, before: Sequence[Effect]) -> list[str]:
    for other in before:
        if other.effect != effect.effect or part_of(effect.effect).several:
            continue
        if part_of(effect.effect).kind.place != "channel":
            return [f"{effect.effect} occurs twice; allowed: once"]
        if other.place == effect.place:
            return [f"{effect.effect} occurs twice on row {channels_of_place(effect.place)}; allowed: once a row"]
    return []
