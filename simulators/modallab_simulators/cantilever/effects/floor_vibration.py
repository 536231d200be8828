"""A floor that shakes."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    return replace(altered, excitation=replace(altered.excitation, floor_rms=effect.parameters["rms_acc"]))


def _check(effect: Effect, rig: Rig) -> list[str]:
    if {"velocity", "displacement"} & {c.quantity for c in rig.channels}:
        return ["floor_vibration: the rig has velocity or displacement channels; allowed: accelerometers only"]
    return []


PART = EffectPart(
    name="floor_vibration",
    rank=430,
    change=_change,
    several=False,
    check=_check,
)
