"""A damper from the beam to ground."""

from dataclasses import replace

import numpy as np

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch, ReplacedTolerance, number_in_deviations


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, dampers=(*s.dampers, (x_of(effect, rig), effect.parameters["c"]))))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    critical = float(np.sqrt(beam.bending_stiffness_n_m2 * beam.mass_kg / beam.length_m**3))
    return (FreeNumber("c", "log", spread_logarithmically(1e-3 * critical, critical, 5)), along_beam())


def _own_deviations(effect: Effect, rig: Rig) -> float:
    return number_in_deviations(effect.parameters["c"], rig.tolerance.damper_n_s_per_m)


MODEL = EffectModel(
    kind=EffectKind(
        "local_damper",
        "structure",
        (Parameter("c", "N s/m", 1e-5, 10.0, "sqrt(EI m/L^3)", spoken="damping coefficient"),),
        "x",
        "a viscous damper to ground at x",
    ),
    rank=110,
    spoken="local damper",
    change=_change,
    moves_poles=True,
    once=True,
    search=EffectSearch(
        rank=70, slots=_slots, tolerance=ReplacedTolerance(deviations=_own_deviations, absorbed_by="damping ratios")
    ),
    experiment="Compare the phases along the beam at a resonance: a single damper changes the phases along the "
    "beam, even damping does not.",
)
