"""A beam that still rings when it is struck."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "residual_ringing",
        "excitation",
        (Parameter("fraction", "", 1e-4, 3.0, spoken="ringing before the hit, as a share of the response to it"),),
        "impact",
        "the beam still rings at the time of the hit",
        tests=("impact",),
    ),
    rank=50,
    spoken="residual ringing",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=True,
    search=None,
    experiment="Wait longer before each hit and repeat the hits.",
)
