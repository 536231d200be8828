"""The effects of one bench, checked against its rig and reported as text."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from modallab.core.effects import Effect
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effects.kinds import KINDS, OPTIONS


@dataclass(frozen=True, slots=True)
class Injected:
    """All effects of a bench, in the order they were given."""

    effects: tuple[Effect, ...] = ()

    def of(self, name: str) -> Iterator[Effect]:
        """Those of one kind."""
        return (e for e in self.effects if e.effect == name)

    def one(self, name: str) -> Effect | None:
        """The only one of a kind, or None."""
        return next(self.of(name), None)

    def number(self, name: str, parameter: str, default: float) -> float:
        """A number of the only effect of a kind, or what holds without it."""
        effect = self.one(name)
        return default if effect is None else effect.parameters.get(parameter, default)

    def on(self, name: str, row: int) -> Effect | None:
        """The effect of one kind on a row."""
        return next((e for e in self.of(name) if e.place["channel"] == row), None)

    def reported(self) -> str:
        """As JSON, in the form of a campaign's truth: effect, family, parameters, place."""
        return json.dumps([reported(e) for e in self.effects])


def reported(effect: Effect) -> dict[str, object]:
    """An effect as a campaign's truth states it."""
    options = OPTIONS.get(effect.effect, ())
    return {
        "effect": effect.effect,
        "family": KINDS[effect.effect].stage,
        "parameters": {k: v for k, v in effect.parameters.items() if k not in options},
        "place": {k: list(v) if isinstance(v, tuple) else v for k, v in effect.place.items()},
    }


_SEVERAL = frozenset(
    {
        "added_mass",
        "stiffness_loss",
        "ground_spring",
        "local_damper",
        "cubic_spring",
        "breathing_crack",
        "support_resonance",
    }
)


def _per_channel(name: str) -> bool:
    return KINDS[name].place == "channel"


def inject(effects: Sequence[Effect], rig: Rig) -> Injected:
    """Place effects on a rig.

    Raises:
        ConfigurationError: the rig has no such channel, no shaker, no room; one that stands for itself occurs twice.
    """
    problems: list[str] = []
    placed = tuple(_at_shaker(e, rig, problems) for e in effects)
    if sum(e.effect in ("clamp_friction", "clearance") for e in placed) > 1:
        problems.append("clamp_friction and clearance are both the joint at the root; allowed: one of them")
    for place, effect in enumerate(placed):
        problems += _channel_problems(effect, rig)
        problems += _number_problems(effect, rig)
        problems += _repeated(effect, placed[:place])
    if problems:
        raise ConfigurationError("\n".join(problems), remedy="correct the effects in the bench's address")
    return Injected(placed)


def _at_shaker(effect: Effect, rig: Rig, problems: list[str]) -> Effect:
    if KINDS[effect.effect].place != "shaker":
        return effect
    if rig.shaker_point is None or rig.beam is None:
        problems.append(f"{effect.effect}: the rig has no shaker")
        return effect
    return effect.model_copy(update={"place": {"x": rig.x_of(rig.shaker_point) / rig.beam.length_m}})


def _channel_problems(effect: Effect, rig: Rig) -> list[str]:
    rows = effect.place.get("channel")
    found: list[str] = []
    for row in rows if isinstance(rows, tuple) else (rows,):
        if not isinstance(row, int) or KINDS[effect.effect].place == "force":
            continue
        if row >= len(rig.channels) or rig.channels[row].quantity == "force":
            names = ", ".join(c.name for c in rig.responses)
            found.append(f"{effect.effect}: channel {row} is no accelerometer of the rig; allowed: {names}")
        elif effect.effect == "position_error":
            found += _off_the_beam(effect, row, rig)
    return found


def _number_problems(effect: Effect, rig: Rig) -> list[str]:
    numbers = effect.parameters
    if effect.effect == "clamp_friction" and numbers["k_stick"] <= numbers["k_slip"]:
        return [f"clamp_friction: k_stick is {numbers['k_stick']:g}; allowed: above k_slip, {numbers['k_slip']:g}"]
    moving = {"velocity", "displacement"} & {c.quantity for c in rig.channels}
    if effect.effect == "floor_vibration" and moving:
        return ["floor_vibration: the rig has velocity or displacement channels; allowed: accelerometers only"]
    return []


def _off_the_beam(effect: Effect, row: int, rig: Rig) -> list[str]:
    point = rig.channels[row].point
    assert rig.beam is not None
    if point is None:
        return []
    x, length = rig.x_of(point), rig.beam.length_m
    if 0 <= x + effect.parameters["dx"] <= length * (1 + 1e-9):
        return []
    return [f"position_error: dx is {effect.parameters['dx']:g} m; allowed: {-x:g} to {length - x:g} m for row {row}"]


def _repeated(effect: Effect, before: Sequence[Effect]) -> list[str]:
    for other in before:
        if other.effect != effect.effect or effect.effect in _SEVERAL:
            continue
        if not _per_channel(effect.effect):
            return [f"{effect.effect} occurs twice; allowed: once"]
        if other.place == effect.place:
            return [f"{effect.effect} occurs twice on row {effect.place['channel']}; allowed: once a row"]
    return []
