"""The true structure with what is linear of its effects: roots, losses of stiffness, attachments, modes beside."""

from dataclasses import replace

import numpy as np

from modallab.core.units import Test
from modallab_simulators.cantilever.altered import Element, StructureChanges
from modallab_simulators.cantilever.attached import AttachedModes
from modallab_simulators.cantilever.basis import Basis, JoinedBasis, ModalBasis
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.cracked import CrackedBeam
from modallab_simulators.cantilever.draw import TrueBeam
from modallab_simulators.cantilever.modes import Modes
from modallab_simulators.cantilever.ritz import PreloadedModes, RotaryModes


def modes_of(beam: CantileverBeam, changes: StructureChanges, test: Test, rotary_inertia_kg_m: float = 0.0) -> Modes:
    """The undamped modes of the structure in one test; the bare beam if nothing of it is changed.

    Args:
        beam: the intact beam.
        changes: what is wrong with it.
        test: which one; the shaker hangs on the beam in the sine test only.
        rotary_inertia_kg_m: of the slices of the beam, per length.
    """
    beam = on_root(beam, changes)
    bare: Modes = CrackedBeam(beam, changes.losses, changes.waves) if changes.losses or changes.waves else beam
    bare = PreloadedModes(bare, changes.preload_n) if changes.preload_n else bare
    if rotary_inertia_kg_m or changes.mass_waves:
        heavier = [(k, a * beam.mass_kg_m) for k, a in changes.mass_waves]
        bare = RotaryModes(bare, rotary_inertia_kg_m, heavier)
    attachments = [*changes.attachments, *(() if test == "impact" else changes.at_shaker)]
    root, hung = changes.root_n_m, changes.absorbers
    return AttachedModes(bare, attachments, root, hung) if attachments or hung or root != np.inf else bare


def beside(basis: Basis, true: TrueBeam, changes: StructureChanges, width_m: float, reach: float) -> Basis:
    """The basis with families of modes that are none of bending in the drive's direction, if sensors see any."""
    for family in changes.side_modes:
        modes = family.modes(true, width_m)
        count = modes.count_below(reach)
        basis = JoinedBasis(basis, ModalBasis(modes, modes.omega(count), np.full(count, family.zeta)), family.share)
    return basis


def on_root(beam: CantileverBeam, changes: StructureChanges) -> CantileverBeam:
    """The beam on the rotational springs at its root, its own and those of effects, each at its stiffest."""
    if not changes.root_nm_rad:
        return beam
    own = 0.0 if beam.kappa == np.inf else 1 / beam.kappa
    added = sum(beam.bending_stiffness_n_m2 / beam.length_m / k for k in changes.root_nm_rad)
    return replace(beam, kappa=1 / (own + added))


def elements_of(beam: CantileverBeam, changes: StructureChanges) -> list[Element]:
    """The nonlinear elements on a beam, whose root already has a joint at its stiffest."""
    return [element(on_root(beam, changes)) for element in changes.elements]
