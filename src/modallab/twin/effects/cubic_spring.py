"""A spring that stiffens with the deflection."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, SteppedLaw
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    return replace(twin, element=NonlinearElement(NonlinearLaw.CUBIC, x_of(effect, rig), (effect.parameters["k3"],)))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    unit = beam.bending_stiffness_n_m2 / beam.length_m**5
    return (FreeNumber("k3", "log", spread_logarithmically(2e2 * unit, 1e8 * unit, 27)), along_beam())


MODEL = EffectModel(
    kind=EffectKind(
        "cubic_spring",
        "structure",
        (Parameter("k3", "N/m^3", 1e2, 1e10, spoken="cubic stiffness"),),
        "x",
        "a spring to ground at x with the force k3 w^3",
        linear=False,
    ),
    rank=50,
    spoken="cubic spring",
    change=_change,
    moves_poles=True,
    once=False,
    search=EffectSearch(rank=80, slots=_slots, law=SteppedLaw(acts="force", on_slowest=4, smooth=True)),
    experiment="Repeat the sines at a third level: the frequencies rise with the square of the amplitude.",
)
