"""Modes beside those of bending along the drive, which hammer, shaker and sensors drive and sense alike."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch
from modallab.twin.structure import Family, SideModes

FAMILIES: dict[str, Family] = {"twist_hz": "twist", "across_hz": "across", "alone_hz": "alone"}
"""The number that gives the lowest frequency of each family."""


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    s, law = twin.structure, effect.parameters
    more = tuple(
        SideModes(family, law[name], law["kg"], law["zeta"], law.get("alone_power", 1.0))
        for name, family in FAMILIES.items()
        if name in law
    )
    return replace(twin, structure=replace(s, side=(*s.side, *more)))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    lowest = (
        FreeNumber(name, "log", spread_logarithmically(10.0, 1000.0, 5), low=1.0, high=5000.0, power=0.0)
        for name in FAMILIES
    )
    return (
        *lowest,
        FreeNumber("alone_power", "plain", (1.0, 2.0), low=1.0, high=8.0, power=0.0),
        FreeNumber(
            "kg",
            "log",
            spread_logarithmically(beam.mass_kg, 1e4 * beam.mass_kg, 3),
            low=1e-2 * beam.mass_kg,
            power=-1.0,
        ),
        FreeNumber("zeta", "log", (0.005,), low=1e-4, high=0.3, power=0.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "side_modes",
        "structure",
        (
            Parameter("twist_hz", "Hz", 1.0, 5000.0, spoken="lowest mode of twisting"),
            Parameter("across_hz", "Hz", 1.0, 5000.0, spoken="lowest mode across the drive"),
            Parameter("alone_hz", "Hz", 1.0, 5000.0, spoken="frequency of the mode"),
            Parameter("alone_power", "", 1.0, 8.0, spoken="exponent of its shape along the beam"),
            Parameter("kg", "kg", 1e-2, 1e6, "m", spoken="modal mass"),
            Parameter("zeta", "", 1e-4, 0.3, spoken="damping ratio"),
        ),
        "all",
        "modes beside those of bending along the drive, the lowest at the frequency that is given: of a beam that "
        "twists, of one that bends across, or one mode alone whose shape goes with (x / L)^alone_power; each swings "
        "at the tip as a mass kg would",
    ),
    rank=25,
    spoken="modes beside those of bending",
    change=_change,
    moves_poles=True,
    once=False,
    search=EffectSearch(rank=25, slots=_slots, inexact=0.01),
    experiment="Hit the beam's left and right edge in turn: modes of twisting change their sign, those of bending do "
    "not; then turn a sensor and the hammer across the drive.",
)
