"""The beam twists: modes beside those of bending."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.beam import TrueBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart, SideFamily
from modallab_simulators.cantilever.modes import Modes, TorsionBar


def _modes(true: TrueBeam, width_m: float) -> Modes:
    return TorsionBar.of(true.beam.length_m, width_m, true.thickness_m, true.youngs_modulus_pa, true.density_kg_m3)


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    family = SideFamily(_modes, effect.parameters["offset"])
    return replace(altered, structure=replace(s, side_modes=(*s.side_modes, family)))


PART = EffectPart(
    name="torsion",
    rank=500,
    change=_change,
    several=False,
    outside=EffectKind(
        "torsion",
        "structure",
        (Parameter("offset", "m", 1e-5, 0.05),),
        "all",
        "hammer, shaker and sensors are offset from the beam's centre line, and so twist it and sense its twist",
    ),
    drawn=Drawn(slope=2.0),
)
