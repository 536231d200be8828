"""Drag of the air."""

from modallab.core.effects import EffectKind, Parameter
from modallab.twin.effect_model import EffectModel, NoChange

MODEL = EffectModel(
    kind=EffectKind(
        "air_drag",
        "structure",
        (Parameter("c2_total", "N s^2/m^2", 1e-2, 1e3),),
        "all",
        "a drag c2_total/L |v| v per length along the beam",
        linear=False,
    ),
    rank=120,
    spoken="air drag",
    change=NoChange.NO_MODEL_YET,
    moves_poles=True,
    once=True,
    search=None,
    experiment="Repeat the sines at a third level: drag damps in proportion to the amplitude, the frequencies stay.",
)
