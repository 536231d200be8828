"""An accelerometer at another place than stated."""

from dataclasses import replace

from modallab.core.effects import Effect, row_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart

ROUNDING = 1e-9
"""Share of the length by which a sensor may leave the beam: one drawn to sit at its very end is there but for this."""


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, moved_m={**c.moved_m, row_of(effect): effect.parameters["dx"]}))


def _check(effect: Effect, rig: Rig) -> list[str]:
    row, dx = row_of(effect), effect.parameters["dx"]
    point = rig.channels[row].point
    assert rig.beam is not None
    if point is None:
        return []
    x, length = rig.x_of(point), rig.beam.length_m
    if -ROUNDING * length <= x + dx <= length * (1 + ROUNDING):
        return []
    return [f"position_error: dx is {dx:g} m; allowed: {-x:g} to {length - x:g} m for row {row}"]


PART = EffectPart(
    name="position_error",
    rank=240,
    change=_change,
    several=False,
    check=_check,
)
