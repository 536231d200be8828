"""A root that sticks and slips."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, SteppedLaw
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s, numbers = twin.structure, effect.parameters
    stick = numbers["k_stick"]
    slider = max(stick - numbers["k_slip"], 1e-6 * stick)
    root = s.root_rotation + s.bending_stiffness / s.length_m / numbers["k_slip"]
    element = NonlinearElement(
        NonlinearLaw.FRICTION, 0.0, (slider, numbers["moment_limit"], numbers.get("sharpness", 0.0))
    )
    return replace(twin, structure=replace(s, root_rotation=root), element=element)


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    unit = beam.bending_stiffness_n_m2 / beam.length_m
    return (
        FreeNumber("k_slip", "log", spread_logarithmically(2.2 * unit, 220 * unit, 5)),
        FreeNumber("k_stick", "log", spread_logarithmically(12 * unit, 1500 * unit, 5), power=-1.0),
        FreeNumber("moment_limit", "log", spread_logarithmically(1.5e-5 * unit, 2.3e-2 * unit, 7), power=-1.0),
        FreeNumber("sharpness", "log", (1.2,), low=1.0, high=100.0, power=0.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "clamp_friction",
        "structure",
        (
            Parameter("k_slip", "N m/rad", 2.0, 200.0, "EI/L", spoken="stiffness while slipping"),
            Parameter("k_stick", "N m/rad", 10.0, 2000.0, "EI/L", spoken="stiffness while sticking"),
            Parameter("moment_limit", "N m", 1e-6, 1e-1, "EI/L", spoken="friction moment"),
        ),
        "root",
        "the root turns against k_slip and, beside it, k_stick - k_slip in series with a slider (Jenkins)",
        linear=False,
    ),
    rank=30,
    spoken="clamp friction",
    change=_change,
    moves_poles=True,
    once=True,
    # How a joint yields is a convention.
    search=EffectSearch(rank=30, slots=_slots, inexact=0.05, law=SteppedLaw(behind="k_stick")),
    experiment="Repeat the sines at a third level: friction softens the root with the level and damps most in between.",
)
