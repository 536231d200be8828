"""A floor that shakes."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "floor_vibration",
        "excitation",
        (Parameter("rms_acc", "m/s^2", 1e-4, 10.0, spoken="rms acceleration"),),
        "base",
        "the base shakes with the acceleration rms_acc",
    ),
    rank=40,
    spoken="floor vibration",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=True,
    search=None,
    experiment="Record the undisturbed bench with an accelerometer on the clamp.",
)
