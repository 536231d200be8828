"""The mains on every row."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "mains_hum",
        "acquisition",
        (Parameter("volts", "V", 1e-5, 1.0, spoken="amplitude"), Parameter("hz", "Hz", 50.0, 60.0, spoken="frequency")),
        "all",
        "a sine at the mains frequency hz on every row, its amplitude volts (0.5 + 0.1 k) in row k",
    ),
    rank=40,
    spoken="mains hum",
    change=NoChange.NO_FORCE_PREDICTS_IT,
    moves_poles=False,
    once=True,
    search=None,
    experiment="Record the undisturbed bench with one supply after the other switched off.",
)
