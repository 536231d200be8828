"""Reads one effect as it stands in the bench's address: `added_mass,mass=0.05,x=0.4`."""

from math import isfinite

from modallab.core.effects import Effect, EffectKind
from modallab.core.places import AlongBeam, NoPlace, OneChannel, Place, TwoChannels
from modallab_simulators.cantilever.effect_part import EffectPart
from modallab_simulators.cantilever.effects import allowed, kinds, part_of


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
        low, high = allowed(part, name)
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
    low, high = allowed(part, name)
    unit = next((p.unit for p in part.kind.parameters if p.name == name), "")
    if low == high:
        return f"{low:g}"
    side = {(True, True): "any number but 0"}.get((isfinite(low), isfinite(high)))
    side = f"{low:g} to {high:g}, not 0" if isfinite(low) and isfinite(high) else side
    side = side or ("above 0" if isfinite(low) else "any number but 0")
    return f"{side} {unit}".strip()
