"""A beam that changes its stiffness over the campaign."""

from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    numbers = effect.parameters
    s = altered.structure
    return replace(altered, structure=replace(s, drift=numbers["EI_drift"], drift_s=numbers.get("over_s", s.drift_s)))


PART = EffectPart(
    name="thermal_drift",
    rank=130,
    change=_change,
    several=False,
    # Over how many seconds of bench time it runs.
    options=("over_s",),
    lasts="over_s",
    limits={"EI_drift": (-0.9, 9.0)},
)
