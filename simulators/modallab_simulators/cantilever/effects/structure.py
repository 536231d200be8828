"""The true structure with its linear effects: roots, losses of stiffness, attachments, dampers."""

from dataclasses import replace
from math import inf

from modallab.schema.rig import Rig
from modallab.schema.units import Test
from modallab_simulators.cantilever.attached import AttachedModes, Attachment
from modallab_simulators.cantilever.basis import Damper
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.cracked import CrackedBeam, Loss
from modallab_simulators.cantilever.effects.injected import Injected
from modallab_simulators.cantilever.effects.nonlinear import joint_stiffness
from modallab_simulators.cantilever.modes import Modes


def modes_of(beam: CantileverBeam, effects: Injected, rig: Rig, test: Test) -> Modes:
    """The undamped modes of the structure in one test; the bare beam if nothing of it is changed."""
    beam = on_root(beam, effects)
    length = beam.length_m
    losses = [Loss(_x(e.place) * length, e.parameters["EI_loss"]) for e in effects.of("stiffness_loss")]
    bare: Modes = CrackedBeam(beam, losses) if losses else beam
    attachments = [*_attachments(effects, rig, length), *(_at_shaker(effects, length) if test == "sine" else ())]
    root = effects.number("clamp_translation", "k_trans", inf)
    return AttachedModes(bare, attachments, root) if attachments or root != inf else bare


def dampers_of(effects: Injected, length_m: float) -> tuple[Damper, ...]:
    """The local dampers."""
    return tuple(Damper(_x(e.place) * length_m, e.parameters["c"]) for e in effects.of("local_damper"))


def on_root(beam: CantileverBeam, effects: Injected) -> CantileverBeam:
    """The beam on all that turns at its root: its own spring, that of the effect, a joint at its stiffest."""
    added = [effects.number("clamp_rotation", "k_rot", inf), joint_stiffness(effects)]
    if min(added) == inf:
        return beam
    own = 0.0 if beam.kappa == inf else 1 / beam.kappa
    return replace(beam, kappa=1 / (own + sum(beam.bending_stiffness_n_m2 / beam.length_m / k for k in added)))


def _attachments(effects: Injected, rig: Rig, length: float) -> list[Attachment]:
    found = [Attachment(_x(e.place) * length, mass=e.parameters["mass"]) for e in effects.of("added_mass")]
    found += [Attachment(_x(e.place) * length, stiffness=e.parameters["k"]) for e in effects.of("ground_spring")]
    each = effects.number("sensor_mass", "mass_each", 0.0)
    if each:
        found += [Attachment(rig.x_of(c.point), mass=each) for c in rig.responses if c.point is not None]
    return found


def _at_shaker(effects: Injected, length: float) -> list[Attachment]:
    found = [Attachment(_x(e.place) * length, mass=e.parameters["mass"]) for e in effects.of("shaker_mass")]
    return found + [
        Attachment(_x(e.place) * length, 1, stiffness=e.parameters["k_rot"]) for e in effects.of("stinger_moment")
    ]


def _x(place: object) -> float:
    assert isinstance(place, dict)
    return float(place["x"])  # pyright: ignore[reportUnknownArgumentType]
