"""A modal model made ready for use: its structure, samples of it, and its FRFs as they were measured."""

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.modification.attachments import AttachedPart
from modallab.modification.coupled import CouplingToStructure, conditioning_of
from modallab.modification.freedoms import Freedom
from modallab.modification.frfs import MeasuredPairs, frf_between
from modallab.modification.modified import ModifiedModes, modified_modes, residues_of
from modallab.modification.poles import StructureWithAttachments
from modallab.modification.remainder import remainder_of_structure
from modallab.modification.response import Between, ModesAtPlaces, modal_states, motion_of_modes
from modallab.modification.samples import freedom_indices, sample_structures
from modallab.modification.state_space import StateSpaceModel, state_space_of
from modallab.modification.structure import At, Receptances, Structure, structure_of

FRF_SAMPLES = 50
"""Of FRFs and motions, which have many numbers: enough to know a standard deviation to 10 %."""


class KnownStructure:
    """A structure known by its modal model, alone or with attachments.

    Attributes:
        model: of it.
        rig: where its points are, and how well everything is known; None where nothing is said.
        changes: what hangs on it.
        taken: what was taken away from the measurement; the structure is the rest.
    """

    def __init__(
        self,
        model: ModalModel,
        rig: Rig | None = None,
        changes: Sequence[AttachedPart] = (),
    ) -> None:
        """Look up what the model knows.

        Args:
            model: with a driving point, or it says nothing of pairs of points that were not measured.
            rig: of the recordings.
            changes: what hangs on it.

        Raises:
            DataError: an output or input without a point.
        """
        self.model, self.rig, self.changes = model, rig, tuple(changes)
        self.taken: tuple[CouplingToStructure, ...] = ()
        self._measured = structure_of(model, rig)

    @property
    def structure(self) -> Structure:
        """The structure of all its points.

        Raises:
            DataError: no sensor stands at a driven point.
        """
        return self._measured.with_scale

    @property
    def sensors(self) -> tuple[Freedom, ...]:
        """(outputs,) where motion was measured."""
        return self._measured.freedoms[: len(self.model.outputs)]

    def measured_pairs(self, outputs: Sequence[At], inputs: Sequence[At]) -> Structure:
        """The structure, for use at pairs of points.

        Raises:
            DataError: a pair was not measured, and no sensor stands at a driven point.
        """
        return self._measured.between(outputs, inputs)

    @property
    def stated_rig(self) -> Rig:
        """The rig, with the places of its points.

        Raises:
            DataError: none is known.
        """
        if self.rig is None:
            raise DataError(
                "the places of the points are not known",
                remedy="name the rig file (--rig), or identify a campaign with one",
            )
        return self.rig

    @cached_property
    def samples(self) -> Structure:
        """(samples, ...) structures that the model leaves possible."""
        return sample_structures(self.model, self.rig)

    @cached_property
    def structure_with_parts(self) -> StructureWithAttachments:
        """With what hangs on it."""
        return StructureWithAttachments.of(self.structure, self.changes)

    @cached_property
    def modes(self) -> ModifiedModes:
        """The modes with what hangs on it."""
        return modified_modes(
            self.structure, self.changes, self.samples, self.without_parts.structure if self.taken else None
        )

    @cached_property
    def conditioning(self) -> float | None:
        """By which factor errors at the worst joint to another structure grow; None without one."""
        parts = [change for change in (*self.taken, *self.changes) if isinstance(change, CouplingToStructure)]
        return max((conditioning_of(self.without_parts.structure, part) for part in parts), default=None)

    @property
    def descriptions(self) -> tuple[str, ...]:
        """What was changed, each in a few words."""
        return tuple(change.description for change in (*self.taken, *self.changes))

    @property
    def without_parts(self) -> "KnownStructure":
        """Without what hangs on it."""
        return KnownStructure(self.model, self.rig)

    @property
    def without_residual_terms(self) -> "KnownStructure":
        """Of its modes alone, with the same changes."""
        bare = self.model.model_copy(update={"residuals": 0 * self.model.residuals})
        return KnownStructure(bare, self.rig).with_changes([*self.taken, *self.changes])

    def with_changes(self, changes: Sequence[AttachedPart]) -> "KnownStructure":
        """With more hung on it.

        Raises:
            DataError: the model does not know a point.
        """
        # What was predicted of this structure is exact enough to be subtracted; what was measured is not.
        away = (
            () if self.changes else tuple(c for c in changes if isinstance(c, CouplingToStructure) and c.measured_part)
        )
        kept = (c for c in changes if c not in away)
        more = KnownStructure(self.model, self.rig, (*self.changes, *kept))
        more._measured, more.taken, more.__dict__["samples"] = self._measured, self.taken, self.samples
        for part in away:
            more._take(part)
        _ = more.structure_with_parts
        return more

    def _take(self, part: CouplingToStructure) -> None:
        """Become what is left without it."""
        assert part.samples is not None
        structure, at = self.structure, part.links(self.structure)
        rest = remainder_of_structure(structure, self.samples, part.other, part.samples, at, part.own)
        self._measured, self.taken = rest.structure, (*self.taken, part)
        self.__dict__["samples"] = rest.samples

    def frf(
        self,
        f: object,
        outputs: Sequence[At] | None = None,
        inputs: Sequence[At] | None = None,
        quantity: FrfQuantity = "mobility",
        *,
        sigma: bool = True,
    ) -> Frf:
        """FRFs between points, measured pairs or not, with their variance.

        Args:
            f: (lines,) Hz, above 0, ascending.
            outputs: points; None for all that have a sensor.
            inputs: points; None for those that were driven.
            quantity: receptance, mobility or inertance.
            sigma: whether to give the variance.

        Raises:
            DataError: frequencies that do not ascend, or a point that the model does not know.
        """
        freedoms = self._measured.freedoms
        left = self.sensors if outputs is None else outputs
        right = [freedoms[c] for c in freedom_indices(self.model, self._measured)[1]] if inputs is None else inputs
        structure = self.measured_pairs(left, right)
        varied = None
        if sigma:
            few = self.samples.first_samples(FRF_SAMPLES)
            varied = self.structure_with_parts.with_samples(few) if self.changes else few
        return frf_between(structure, self._now, varied, f, left, right, quantity)

    @cached_property
    def _now(self) -> Receptances:
        if self.changes:
            return self.structure_with_parts
        return self._measured if self.taken else MeasuredPairs.of(self.model, self._measured)

    def response(
        self,
        force: Real,
        dt: float,
        at: Sequence[At],
        of: Sequence[At],
        quantity: Quantity = "acceleration",
        between: Between = "band-limited",
        start: dict[Quantity, dict[At, float]] | None = None,
    ) -> Real:
        """(outputs, samples) motion that forces give.

        Args:
            force: (inputs, samples) N.
            dt: s between samples.
            at: (inputs,) points of the forces.
            of: (outputs,) points of the motion.
            quantity: displacement, velocity or acceleration, in m, m/s or m/s^2.
            between: what the force is between its samples.
            start: displacement and velocity of points at the first sample, as {"displacement": {10: 0.001}}; None
                for rest.

        Raises:
            DataError: a force that cannot be, or a point that the model does not know.
        """
        modes = self._modes_at(of, at)
        return motion_of_modes(modes, force, dt, quantity, between, None if start is None else self._started(start))

    def standard_deviation(self, of: Callable[["KnownStructure"], Real]) -> Real:
        """Standard deviation of what is computed of a structure, over those that the model leaves possible.

        Args:
            of: what is computed, an array of any shape.

        Raises:
            DataError: as what is computed.
        """
        few = self.samples.first_samples(FRF_SAMPLES)
        first = np.asarray(of(self._sampled(few.one_sample(0))), np.float64)
        total, squares = np.zeros_like(first), np.zeros_like(first)
        # About the first of them: their own size would hide how little they differ.
        for k in range(1, len(few.poles)):
            off = of(self._sampled(few.one_sample(k))) - first
            total += off
            squares += off**2
        n = len(few.poles)
        return np.asarray(np.sqrt(np.maximum(squares - total**2 / n, 0) / (n - 1)), np.float64)

    def _sampled(self, structure: Structure) -> "KnownStructure":
        """One of the structures that are possible, with the same changes."""
        one = KnownStructure(self.model, self.rig, self.changes)
        one._measured = structure
        one.__dict__["samples"] = None
        if not self.changes:
            one.__dict__["_now"] = structure
        return one

    def _modes_at(self, of: Sequence[At], at: Sequence[At]) -> ModesAtPlaces:
        structure = self.measured_pairs(of, at)
        poles, psi = self._poles_and_shapes
        left, right = structure.unit_vectors(of), structure.unit_vectors(at)
        return ModesAtPlaces(poles, psi @ left, psi @ right, self._now, left, right, self.model.band_hz)

    def state_space(self, at: Sequence[At], of: Sequence[At], quantity: Quantity) -> StateSpaceModel:
        """From forces at points to motions of points, without what lies outside the band.

        Raises:
            DataError: a point that the model does not know.
        """
        modes = self._modes_at(of, at)
        names = [[self._measured.freedoms[self._measured.index(a)][0] for a in places] for places in (of, at)]
        return state_space_of(modes.poles, self._pole_sigma, modes.out, modes.into, quantity, *names)

    @property
    def poles(self) -> Complex:
        """(modes,) rad/s, with what hangs on it."""
        if not self.changes:
            return self._measured.poles
        m = self.modes
        return 2 * np.pi * m.frequency_hz * (-m.damping_ratio + 1j * np.sqrt(1 - m.damping_ratio**2))

    @property
    def _pole_sigma(self) -> tuple[Real, Real]:
        """(modes,) of frequencies in Hz, and of damping ratios."""
        if self.changes:
            return self.modes.frequency_sigma_hz, self.modes.damping_sigma
        poles = self.samples.poles
        return np.std(np.abs(poles), axis=0) / (2 * np.pi), np.std(-poles.real / np.abs(poles), axis=0)

    @cached_property
    def _poles_and_shapes(self) -> tuple[Complex, Complex]:
        return self.poles, residues_of(self.structure_with_parts, self.poles) if self.changes else self._measured.psi

    def _started(self, start: dict[Quantity, dict[At, float]]) -> Complex:
        poles, psi = self._poles_and_shapes
        at = {name: psi @ self.structure.unit_vectors(list(values)) for name, values in start.items()}
        return modal_states(at, poles, {name: np.array(list(values.values())) for name, values in start.items()})
