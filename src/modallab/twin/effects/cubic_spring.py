"""A spring that stiffens with the deflection."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "cubic_spring",
        "structure",
        (Parameter("k3", "N/m^3", 1e2, 1e10),),
        "x",
        "a spring to ground at x with the force k3 w^3",
        linear=False,
    ),
    rank=50,
    spoken="cubic spring",
    change=NoChange.NO_MODEL_YET,
    moves_poles=True,
    once=False,
    search=None,
    experiment="Repeat the sines at a third level: the frequencies rise with the square of the amplitude.",
)
