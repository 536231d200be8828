"""Modes beside those of bending in the drive's direction."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import inf, pi

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.beam import CantileverBeam, TrueBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart, SideFamily
from modallab_simulators.cantilever.modes import Modes, SingleMode, TorsionBar

LOWEST = 3.5160152685
"""(beta L)^2 of a cantilever's first mode."""


def _twist(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    """A bar whose angle counts as the displacement: its inertia in kg, so that each mode shows the tip law["kg"]."""
    length = true.beam.length_m
    inertia = 2 * law["kg"] / length
    return TorsionBar(length, inertia * (4 * length * law["twist_hz"]) ** 2, inertia)


def _across(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    length = true.beam.length_m
    mass = 4 * law["kg"] / length
    return CantileverBeam(length, mass * (2 * pi * law["across_hz"] * length**2 / LOWEST) ** 2, mass, inf)


def _alone(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    return SingleMode(true.beam.length_m, law["alone_hz"], law["kg"], law.get("alone_power", 1.0))


FAMILIES = {"twist_hz": _twist, "across_hz": _across, "alone_hz": _alone}


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s, law = altered.structure, effect.parameters
    more = (SideFamily(partial(modes, law), 1.0, law["zeta"]) for name, modes in FAMILIES.items() if name in law)
    return replace(altered, structure=replace(s, side_modes=(*s.side_modes, *more)))


PART = EffectPart(
    name="side_modes",
    rank=615,
    change=_change,
    several=True,
    outside=EffectKind(
        "side_modes",
        "structure",
        (Parameter("kg", "kg", 1e-2, 1e6, "m"),),
        "all",
        "modes beside those of bending",
    ),
)
