"""A row that is cut at a level."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "clipping",
        "sensor",
        (Parameter("fraction_of_peak", "", 0.02, 0.999, spoken="remaining share of the peak"),),
        "channel",
        "one channel is clipped at fraction_of_peak of its true peak",
        linear=False,
    ),
    rank=80,
    spoken="clipping",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=False,
    search=None,
    experiment="Repeat the hardest hits more softly: flat tops vanish below the level.",
)
