"""The true structure with its linear effects: roots, losses of stiffness, attachments, dampers."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, pi

import numpy as np

from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab_simulators.cantilever.attached import Absorber, AttachedModes, Attachment
from modallab_simulators.cantilever.basis import Basis, ModalBasis
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.cracked import CrackedBeam, Loss
from modallab_simulators.cantilever.damped import Damper
from modallab_simulators.cantilever.draw import TrueBeam
from modallab_simulators.cantilever.effects.injected import Injected
from modallab_simulators.cantilever.effects.nonlinear import joint_stiffness
from modallab_simulators.cantilever.joined import JoinedBasis
from modallab_simulators.cantilever.modes import Modes
from modallab_simulators.cantilever.preloaded import PreloadedModes
from modallab_simulators.cantilever.rotary import RotaryModes
from modallab_simulators.cantilever.torsion import TorsionBar

SIDE_ZETA = 0.004
"""Damping ratio of modes that are none of bending in the drive's direction."""


def modes_of(beam: CantileverBeam, effects: Injected, rig: Rig, test: Test, rotary_inertia_kg_m: float = 0.0) -> Modes:
    """The undamped modes of the structure in one test; the bare beam if nothing of it is changed.

    Args:
        beam: the intact beam.
        effects: what is wrong with it.
        rig: where sensors and shaker are.
        test: which one; the shaker hangs on the beam in the sine test only.
        rotary_inertia_kg_m: of the slices of the beam, per length.
    """
    beam = on_root(beam, effects)
    length = beam.length_m
    losses = [Loss(_x(e.place) * length, e.parameters["EI_loss"]) for e in effects.of("stiffness_loss")]
    bare: Modes = CrackedBeam(beam, losses) if losses else beam
    preload = effects.number("axial_preload", "force", 0.0)
    bare = PreloadedModes(bare, preload) if preload else bare
    bare = RotaryModes(bare, rotary_inertia_kg_m) if rotary_inertia_kg_m else bare
    attachments = [*_attachments(effects, rig, length), *(_at_shaker(effects, length) if test == "sine" else ())]
    root = effects.number("clamp_translation", "k_trans", inf)
    hung = [_absorber(e.place, e.parameters, length) for e in effects.of("support_resonance")]
    return AttachedModes(bare, attachments, root, hung) if attachments or hung or root != inf else bare


def beside(basis: Basis, true: TrueBeam, effects: Injected, rig: Rig, reach: float) -> Basis:
    """The basis with families of modes that are none of bending in the drive's direction, if sensors see any."""
    assert rig.beam is not None
    width, beam = rig.beam.width_m, true.beam
    offset = effects.number("torsion", "offset", 0.0)
    if offset:
        bar = TorsionBar.of(beam.length_m, width, true.thickness_m, true.youngs_modulus_pa, true.density_kg_m3)
        basis = JoinedBasis(basis, _family(bar, reach), offset)
    share = effects.number("cross_axis", "share", 0.0)
    if share:
        across = replace(beam, bending_stiffness_n_m2=beam.bending_stiffness_n_m2 * (width / true.thickness_m) ** 2)
        basis = JoinedBasis(basis, _family(across, reach), share)
    return basis


def _family(modes: Modes, reach: float) -> ModalBasis:
    count = modes.count_below(reach)
    return ModalBasis(modes, modes.omega(count), np.full(count, SIDE_ZETA))


def _absorber(place: object, numbers: Mapping[str, float], length: float) -> Absorber:
    return Absorber(_x(place) * length, numbers["mass"], numbers["mass"] * (2 * pi * numbers["hz"]) ** 2)


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
