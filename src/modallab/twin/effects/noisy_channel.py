"""A row with more noise than the converter has."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "noisy_channel",
        "sensor",
        (Parameter("factor", "", 1.3, 1000.0, spoken="factor of the noise"),),
        "channel",
        "the noise of one channel is factor times the converter's",
    ),
    rank=40,
    spoken="noisy channel",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=False,
    search=None,
    experiment="Record the undisturbed bench with the cable of this row exchanged: noise of the cable moves with "
    "the cable.",
)
