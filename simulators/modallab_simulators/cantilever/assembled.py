"""The true structure with what is linear of its effects: roots, losses of stiffness, attachments, modes beside.

A structure that differs a little from another has modes that are sums of the other's modes (Rayleigh-Ritz).
It differs by how its slices turn and what they weigh, or by an axial force.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from modallab.core.arrays import Real, gauss_legendre
from modallab.core.units import Test
from modallab_simulators.cantilever.attached import SUMMED, AttachedModes
from modallab_simulators.cantilever.basis import Basis, JoinedBasis, ModalBasis
from modallab_simulators.cantilever.beam import CantileverBeam, TrueBeam
from modallab_simulators.cantilever.cracked import CrackedBeam
from modallab_simulators.cantilever.effect_part import Element, StructureChanges
from modallab_simulators.cantilever.modes import Modes, SolvedModes, eigh


class RitzModes(SolvedModes):
    """Sums of a bare structure's modes, behind the interface of modes.

    Args:
        bare: the structure without what is added.
        nodes: at so many places along the beam what is added is integrated.
    """

    def __init__(self, bare: Modes, nodes: int) -> None:
        super().__init__(bare)
        self._count = nodes

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement or slope of the modes, (points, count)."""
        return self._bare.shapes(x_m, SUMMED, order) @ self._solved[1][:, :count]

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        return self._bare.participation(SUMMED) @ self._solved[1][:, :count]

    @cached_property
    def _nodes(self) -> tuple[Real, Real]:
        """Places along the beam in m, and their weights in an integral, (nodes,)."""
        at, weights = gauss_legendre(self._count)
        half = self.length_m / 2
        return half * (at + 1), weights * half


_NODES = 320


class RotaryModes(RitzModes):
    """A structure with rotary inertia, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: slices add the integral of rho I W_i' W_j' to their mass (Rayleigh's beam:
    Han, Benaroya and Wei, Dynamics of transversely vibrating beams, Journal of Sound and Vibration 225, 1999).

    Args:
        bare: the structure without.
        inertia_kg_m: rho I, moment of inertia of the slices per length.
        waves: (k, a): rho A a cos(k pi x / L) that each slice weighs more, kg/m.
    """

    def __init__(self, bare: Modes, inertia_kg_m: float, waves: Sequence[tuple[int, float]] = ()) -> None:
        super().__init__(bare, _NODES)
        self._inertia, self._waves = inertia_kg_m, tuple(waves)

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,); a shift turns no slice."""
        x_m, weights = self._nodes
        heavier = (self._heavier(x_m) * weights) @ self._bare.shapes(x_m, SUMMED)
        return (self._bare.participation(SUMMED) + heavier) @ self._solved[1][:, :count]

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`: slices at rest have no inertia, (points,)."""
        return self._bare.flexibility(x_m, force_x_m, seen, put)

    def _heavier(self, x_m: Real) -> Real:
        terms = [a * np.cos(k * np.pi * x_m / self.length_m) for k, a in self._waves]
        return np.sum([np.zeros_like(x_m), *terms], axis=0)

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        x_m, weights = self._nodes
        slopes = self._bare.shapes(x_m, SUMMED, 1) * np.sqrt(weights)[:, None]
        mass = np.eye(SUMMED) + self._inertia * slopes.T @ slopes
        if self._waves:
            shapes = self._bare.shapes(x_m, SUMMED)
            mass += shapes.T @ (shapes * (self._heavier(x_m) * weights)[:, None])
        # By 1 / omega^2 the lowest mode is exact to the last digit, and with it what modes answer statically.
        period = 1 / self._bare.omega(SUMMED)
        values, vectors = eigh(mass * np.outer(period, period))
        omega = values[::-1] ** -0.5
        return omega, period[:, None] * vectors[:, ::-1] * omega


_PRELOADED_NODES = 600


class PreloadedModes(RitzModes):
    """A structure under an axial force, behind the interface of its modes.

    Rayleigh-Ritz on the modes without: the force adds the integral of P W_i' W_j' to their stiffness (Blevins, 8.1).

    Args:
        bare: the structure without.
        force_n: P, positive where it pulls.
    """

    def __init__(self, bare: Modes, force_n: float) -> None:
        super().__init__(bare, _PRELOADED_NODES)
        self._force = force_n

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`, (points,)."""
        omega, vectors = self._solved
        to, load = self._bare.shapes(x_m, SUMMED, seen), self._bare.shapes(np.array([force_x_m]), SUMMED, put)[0]
        with_force = (to @ vectors / omega**2) @ (vectors.T @ load)
        without = (to / self._bare.omega(SUMMED) ** 2) @ load
        return self._bare.flexibility(x_m, force_x_m, seen, put) + with_force - without

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        x_m, weights = self._nodes
        slopes = self._bare.shapes(x_m, SUMMED, 1)
        stiffness = np.diag(self._bare.omega(SUMMED) ** 2) + self._force * slopes.T @ (slopes * weights[:, None])
        values, vectors = eigh(stiffness)
        return np.sqrt(values), vectors


def undamped_modes_in_test(
    beam: CantileverBeam, changes: StructureChanges, test: Test, rotary_inertia_kg_m: float = 0.0
) -> Modes:
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


def with_side_modes(basis: Basis, true: TrueBeam, changes: StructureChanges, width_m: float, reach: float) -> Basis:
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
