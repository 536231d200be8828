"""A root with free play."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "clearance",
        "structure",
        (Parameter("k_contact", "N m/rad", 1.0, 500.0, "EI/L"), Parameter("gap", "rad", 1e-6, 1e-2)),
        "root",
        "a free play at the root: beyond the gap a spring k_contact takes over",
        linear=False,
    ),
    rank=40,
    spoken="clearance",
    change=NoChange.NO_MODEL_YET,
    moves_poles=True,
    once=True,
    search=None,
    experiment="Repeat the sines at a third level: a play stiffens the root with the level, friction softens it.",
)
