"""A force at one place that follows the beam's own motion there."""

from dataclasses import replace
from math import pi

from modallab.core.effects import Effect, EffectKind, Parameter, x_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, along_beam, spread_logarithmically, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s, x, law = twin.structure, x_of(effect, rig), effect.parameters
    if law.get("k"):
        s = replace(s, springs=(*s.springs, (x, law["k"])))
    if law.get("c"):
        s = replace(s, dampers=(*s.dampers, (x, law["c"])))
    if law.get("m"):
        s = replace(s, masses=(*s.masses, (x, law["m"])))
    if law.get("hung_m"):
        s = replace(s, hung=(*s.hung, (x, law["hung_m"], law["hung_m"] * (2 * pi * law["hung_hz"]) ** 2)))
    return replace(twin, structure=s)


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    stiffness, mass = beam.bending_stiffness_n_m2 / beam.length_m**3, beam.mass_kg
    # A spring that pulls away from rest must leave the beam stable: at its tip it may take 3 EI/L^3 off.
    return (
        FreeNumber(
            "k", "plain", values_of_both_signs(stiffness, 100 * stiffness, 2), scale=stiffness, low=-2.5 * stiffness
        ),
        FreeNumber("c", "log", spread_logarithmically(1e-2 * (stiffness * mass) ** 0.5, (stiffness * mass) ** 0.5, 3)),
        FreeNumber("m", "plain", values_of_both_signs(0.01 * mass, 0.1 * mass, 2), scale=0.1 * mass, low=-0.1 * mass),
        FreeNumber(
            "hung_m", "log", spread_logarithmically(0.003 * mass, 0.3 * mass, 3), low=1e-6 * mass, high=3 * mass
        ),
        FreeNumber("hung_hz", "log", spread_logarithmically(4.0, 400.0, 12), low=1.0, high=900.0, power=0.0),
        along_beam(),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "point_law",
        "structure",
        (
            Parameter("k", "N/m", 1e-3, 1e4, "EI/L^3", signed=True, spoken="stiffness"),
            Parameter("c", "N s/m", 1e-5, 10.0, "sqrt(EI m/L^3)", spoken="damping coefficient"),
            Parameter("m", "kg", 1e-5, 1.0, "m", signed=True, spoken="mass"),
            Parameter("hung_m", "kg", 1e-5, 3.0, "m", spoken="mass on the spring"),
            Parameter("hung_hz", "Hz", 1.0, 900.0, spoken="frequency of the mass on the spring"),
        ),
        "x",
        "a force at x of -(k + c s + m s^2) times the beam's displacement there, and of a mass hung_m on a spring with "
        "its own resonance at hung_hz; missing numbers are zero",
    ),
    rank=10,
    spoken="a force at one place that follows the motion there",
    change=_change,
    moves_poles=True,
    once=False,
    search=EffectSearch(rank=10, slots=_slots, inexact=0.01),
    experiment="Fasten or remove what touches the beam at this place, and repeat the hits.",
)
