"""A channel that loses some of its samples."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "row_hold",
        "acquisition",
        (
            Parameter("share", "", 1e-5, 0.5, spoken="share of samples lost"),
            Parameter("kept", "", 0.0, 1.0, spoken="replacement: the previous sample (1) or 0 (0)"),
        ),
        "channel",
        "a share of one channel's samples is lost; in their place stands kept times the sample before, 0 or 1 times",
    ),
    rank=50,
    spoken="lost samples",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=False,
    search=None,
    experiment="Record the channel at another input, then through another cable: find with which the losses move.",
)
