"""A beam that bends more at one place."""

from dataclasses import replace

from modallab.core.effects import Effect, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.cracked import LocalStiffnessLoss
from modallab_simulators.cantilever.effect_part import AlteredBench, Drawn, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    s = altered.structure
    return replace(
        altered,
        structure=replace(s, losses=(*s.losses, LocalStiffnessLoss(x_of(effect, rig), effect.parameters["EI_loss"]))),
    )


PART = EffectPart(
    name="stiffness_loss",
    rank=100,
    change=_change,
    several=True,
    limits={"EI_loss": (0.0, 0.99)},
    drawn=Drawn(places=(0.08, 0.7)),
)
