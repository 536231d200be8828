"""The effects of one bench, checked against its rig and reported as text."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field

from modallab.core.effects import Effect
from modallab.core.errors import ConfigurationError
from modallab.core.places import AlongBeam, rows_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.altered import Altered
from modallab_simulators.cantilever.effects import part_of, parts


@dataclass(frozen=True, slots=True)
class Injected:
    """All effects of a bench, in the order they were given, and the bench as they leave it."""

    effects: tuple[Effect, ...] = ()
    altered: Altered = field(default_factory=Altered)

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


def inject(effects: Sequence[Effect], rig: Rig) -> Injected:
    """Place effects on a rig.

    Raises:
        ConfigurationError: the rig has no such channel, no shaker, no room; one that stands for itself occurs twice.
    """
    problems: list[str] = []
    placed = tuple(_at_shaker(e, rig, problems) for e in effects)
    if sum(part_of(e.effect).joint for e in placed) > 1:
        joints = " and ".join(name for name, part in parts().items() if part.joint)
        problems.append(f"{joints} are both the joint at the root; allowed: one of them")
    for place, effect in enumerate(placed):
        problems += _channel_problems(effect, rig) or part_of(effect.effect).check(effect, rig)
        problems += _repeated(effect, placed[:place])
    if problems:
        raise ConfigurationError("\n".join(problems), remedy="correct the effects in the bench's address")
    altered = Altered()
    for effect in sorted(placed, key=lambda e: part_of(e.effect).rank):
        altered = part_of(effect.effect).change(altered, effect, rig)
    return Injected(placed, altered)


def _at_shaker(effect: Effect, rig: Rig, problems: list[str]) -> Effect:
    if part_of(effect.effect).kind.place != "shaker":
        return effect
    if rig.shaker_point is None or rig.beam is None:
        problems.append(f"{effect.effect}: the rig has no shaker")
        return effect
    return effect.model_copy(update={"place": AlongBeam(x=rig.x_of(rig.shaker_point) / rig.beam.length_m)})


def _channel_problems(effect: Effect, rig: Rig) -> list[str]:
    rows = rows_of(effect.place)
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
            return [f"{effect.effect} occurs twice on row {rows_of(effect.place)}; allowed: once a row"]
    return []
