"""The beam bends across the drive too: modes beside those along it."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.beam import TrueBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart, SideFamily
from modallab_simulators.cantilever.modes import Modes


def _modes(true: TrueBeam, width_m: float) -> Modes:
    beam = true.beam
    return replace(beam, bending_stiffness_n_m2=beam.bending_stiffness_n_m2 * (width_m / true.thickness_m) ** 2)


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    family = SideFamily(_modes, effect.parameters["share"])
    return replace(altered, structure=replace(s, side_modes=(*s.side_modes, family)))


PART = EffectPart(
    name="cross_axis",
    rank=530,
    change=_change,
    several=False,
    outside=EffectKind(
        "cross_axis",
        "sensor",
        (Parameter("share", "", 1e-4, 0.5),),
        "all",
        "hits, shaker and sensors have a share across the drive's direction, in which the beam has modes of its own",
    ),
    limits={"share": (0.0, 1.0)},
    drawn=Drawn(slope=2.0),
)
