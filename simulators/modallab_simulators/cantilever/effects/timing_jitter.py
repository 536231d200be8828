"""A converter whose instants are uneven."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    c = altered.chain
    return replace(altered, chain=replace(c, jitter_s=effect.parameters["seconds_rms"]))


PART = EffectPart(
    name="timing_jitter",
    rank=570,
    change=_change,
    several=False,
    outside=EffectKind(
        "timing_jitter",
        "acquisition",
        (Parameter("seconds_rms", "s", 1e-9, 1e-3),),
        "all",
        "every sampling instant is off by a random time of seconds_rms, the same for all rows",
    ),
)
