"""An accelerometer that rocks on its mount."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Mount, Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    mount = Mount(row_of(effect), effect.parameters["hz"], effect.parameters["zeta"])
    return replace(twin, chain=replace(twin.chain, mounts=(*twin.chain.mounts, mount)))


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    # From farther than half of such a step a fit loses its resonance, by ever more damping.
    hz = (*spread_logarithmically(60.0, 2e3, 17), 4e3, 8e3)
    return (
        FreeNumber("hz", "log", hz, low=40.0, high=2e4, power=-2.0),
        FreeNumber("zeta", "log", (0.04,), low=1e-3, high=0.4, power=0.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "loose_mount",
        "sensor",
        (
            Parameter("hz", "Hz", 50.0, 5e3, spoken="resonance frequency"),
            Parameter("zeta", "", 1e-3, 0.3, spoken="damping ratio"),
        ),
        "channel",
        "one accelerometer stands on a mount with a resonance at hz and the damping ratio zeta",
    ),
    rank=70,
    spoken="loose mount",
    change=_change,
    moves_poles=False,
    once=False,
    # Wax or a loose stud is no pure spring and dashpot.
    search=EffectSearch(rank=240, slots=_slots, inexact=0.03),
    experiment="Fasten the accelerometer again and repeat the hits: a resonance of the mount moves or disappears.",
)
