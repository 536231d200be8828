"""A root that sticks and slips."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "clamp_friction",
        "structure",
        (
            Parameter("k_slip", "N m/rad", 2.0, 200.0, "EI/L"),
            Parameter("k_stick", "N m/rad", 10.0, 2000.0, "EI/L"),
            Parameter("moment_limit", "N m", 1e-6, 1e-1, "EI/L"),
        ),
        "root",
        "the root turns against k_slip and, beside it, k_stick - k_slip in series with a slider (Jenkins)",
        linear=False,
    ),
    rank=30,
    spoken="clamp friction",
    change=NoChange.NO_MODEL_YET,
    moves_poles=True,
    once=True,
    search=None,
    experiment="Repeat the sines at a third level: friction softens the root with the level and damps most in between.",
)
