"""A crack that opens and closes."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "breathing_crack",
        "structure",
        (Parameter("EI_loss_open", "", 1e-4, 0.95),),
        "x",
        "a stiffness loss about x while the curvature is positive, none while it is negative",
        linear=False,
    ),
    rank=90,
    spoken="breathing crack",
    change=NoChange.NO_MODEL_YET,
    moves_poles=True,
    once=False,
    search=None,
    experiment="Look for even overtones in the sine responses: a crack that breathes makes them at every level.",
)
