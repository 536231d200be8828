"""What a modal model is used for: FRFs at any pair, the response to forces, changes of the structure, state spaces."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel

from modallab.core.arrays import Real
from modallab.core.documents.model_use import ForceKind
from modallab.core.errors import DataError
from modallab.core.frf import FrfQuantity
from modallab.core.units import Quantity
from modallab.modification.attachments import AttachedPart, Element
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.frfs import lines_with_peaks
from modallab.modification.known import KnownStructure
from modallab.modification.motion import force_samples
from modallab.modification.response import Between
from modallab.modification.state_space import StateSpaceModel
from modallab.modification.structure import At
from modallab.notebook.display import DisplayedTable
from modallab.notebook.inverse_problems import ModelInverse
from modallab.notebook.measured_frf import MeasuredFrf
from modallab.notebook.predicted_motion import PredictedMotion
from modallab.reporting.modification_table import check_predictions, modified_rows, write_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LINES = 1000
"""Of a figure over the band."""


class ModelPredictions(ModelInverse):
    """Predictions by a model or a changed model; `known` is the structure."""

    __slots__ = ()

    @property
    def known_structure(self) -> KnownStructure:
        """The structure of the model, with its attached parts."""
        raise NotImplementedError

    def frf(
        self,
        f: ArrayLike,
        outputs: Sequence[At] | None = None,
        inputs: Sequence[At] | None = None,
        quantity: FrfQuantity = "mobility",
        *,
        residual_terms: bool = True,
    ) -> MeasuredFrf:
        """FRFs at any pairs of points, with their variance; `save` writes them for other programs.

        Args:
            f: (lines,) frequencies in Hz, above 0, ascending.
            outputs: points, or (point, axis); None for all that have a sensor.
            inputs: points; None for those that were driven.
            quantity: receptance, mobility or inertance.
            residual_terms: whether to include residual terms; without them FRFs are those of the modes alone.

        Raises:
            DataError: frequencies that do not ascend, an unknown point, or no driving point.
        """
        known = self.known_structure if residual_terms else self.known_structure.without_residual_terms
        return MeasuredFrf.of(known.frf(np.asarray(f), outputs, inputs, quantity))

    def response(
        self,
        force: ArrayLike | ForceKind,
        dt: float,
        at: At | Sequence[At],
        of: At | Sequence[At] | None = None,
        quantity: Quantity = "acceleration",
        between: Between = "band-limited",
        start: Mapping[Quantity, Mapping[At, float]] | None = None,
        seconds: float | None = None,
    ) -> PredictedMotion:
        """The response to forces, exact for the assumed course between their samples.

        Args:
            force: (samples,) N, or (inputs, samples); or `ml.ImpulseForce`, `ml.SineForce`, `ml.SweepForce`,
                `ml.RandomForce`.
            dt: s between samples.
            at: point of the force, or a list of points.
            of: points of the motion; None for all with a sensor.
            quantity: displacement, velocity or acceleration, in m, m/s or m/s^2.
            between: "band-limited", as records are, or "linear" from sample to sample.
            start: displacements and velocities at the first sample, as {"displacement": {10: 0.001}}; None for rest.
            seconds: duration of a force that is not an array.

        Raises:
            DataError: an impossible force, or an unknown point.
        """
        if isinstance(force, BaseModel):
            if seconds is None:
                raise DataError("the duration of the force is missing", remedy="give seconds=10")
            force = force_samples(force, dt, max(2, round(seconds / dt)))
        asked = None if of is None else _list_of_places(of)
        return PredictedMotion.of(self.known_structure, force, dt, _list_of_places(at), asked, quantity, between, start)

    def state_space(
        self, at: At | Sequence[At], of: Sequence[At] | None = None, quantity: Quantity = "acceleration"
    ) -> StateSpaceModel:
        """Matrices A, B, C, D from forces in N to motions, without residual terms.

        Args:
            at: point of the force, or a list of points.
            of: points of the motion; None for all with a sensor.
            quantity: displacement, velocity or acceleration.

        Raises:
            DataError: an unknown point, or no driving point.
        """
        return self.known_structure.state_space(_list_of_places(at), self._sensors() if of is None else of, quantity)

    def modify(
        self,
        *changes: AttachedPart,
        at: At | None = None,
        to: At | None = None,
        mass: float = 0.0,
        spring: float = 0.0,
        damper: float = 0.0,
    ) -> "ChangedModel":
        """The structure with masses, springs, dampers, absorbers or links.

        Args:
            changes: `ml.Element`, `ml.TunedAbsorber`, `ml.RigidLink`, `ml.CouplingToStructure`; several act at once.
            at: point of a mass, spring or damper given by the numbers below.
            to: the other end of that spring and damper; None for ground.
            mass: kg; negative to remove a mass.
            spring: N/m.
            damper: N s/m.

        Raises:
            DataError: no change, or an unknown point.
        """
        own = () if at is None else (Element(at, to, mass, spring, damper),)
        if not (changes or own):
            raise DataError("there is no change", remedy="give mass=0.05, at=8, or changes such as ml.RigidLink(8)")
        return ChangedModel(self.known_structure.with_changes((*changes, *own)))

    def couple(
        self,
        other: "ModelPredictions",
        at: Sequence[tuple[At, At]],
        *,
        joint_spring: float | None = None,
        remove: bool = False,
    ) -> "ChangedModel":
        """Couple another structure, or remove the other structure from a measurement of both.

        Args:
            other: its model.
            at: pairs of a point of this structure and one of the other.
            joint_spring: N/m of the joint at each pair; None for rigid ones.
            remove: whether the other structure is removed, such as a fixture.

        Raises:
            DataError: an unknown point, or a changed other structure.
        """
        known = other.known_structure
        if known.changes:
            raise DataError(
                f"the other structure is changed: {known.changes[0].description}",
                remedy="couple the structure as measured",
            )
        return self.modify(
            CouplingToStructure(known.structure, tuple(at), joint_spring, -1 if remove else 1, samples=known.samples)
        )


def _list_of_places(given: At | Sequence[At]) -> list[At]:
    """One place or several; a pair of a number and an axis is one."""
    alone = isinstance(given, int) or (len(given) == 2 and isinstance(given[1], str))
    return cast("list[At]", [given] if alone else list(cast("Sequence[At]", given)))


class ChangedModel(ModelPredictions):
    """A changed structure, predicted from the model without the changes."""

    __slots__ = ("_known",)

    def __init__(self, known: KnownStructure) -> None:
        self._known = known

    @property
    def known_structure(self) -> KnownStructure:
        """The structure with its attached parts."""
        return self._known

    @property
    def frequency_hz(self) -> Real:
        """(modes,) within the band of the model."""
        return self._known.modes.frequency_hz

    @property
    def frequency_sigma_hz(self) -> Real:
        """(modes,) one standard deviation."""
        return self._known.modes.frequency_sigma_hz

    @property
    def damping_ratio(self) -> Real:
        """(modes,)"""
        return self._known.modes.damping_ratio

    @property
    def damping_sigma(self) -> Real:
        """(modes,) one standard deviation."""
        return self._known.modes.damping_sigma

    @property
    def conditioning(self) -> float | None:
        """Growth factor of receptance errors in the forces of the joint, from 1 on; None without a joint."""
        return self._known.conditioning

    def table(self) -> DisplayedTable:
        """Frequency and damping of each mode before and after, with one standard deviation."""
        words = list(self._known.descriptions)
        return DisplayedTable(*modified_rows(self._known, words))

    def check(self, measured: ModelPredictions) -> DisplayedTable:
        """Compare each predicted mode with a model that was measured with the changes.

        Args:
            measured: its model.
        """
        found = check_predictions(self._known.modes, measured.known_structure.model)
        return DisplayedTable(("predicted and measured",), [(one.words,) for one in found])

    def plot(self, at: At, of: At | None = None) -> "Figure":
        """Mobility from one point to another before and after, over the band of the model.

        Args:
            at: point of the force.
            of: point of the motion; None for the same.
        """
        from modallab.reporting.figures.mobility import mobility_before_after

        alone, to = self._known.without_parts, [at if of is None else of]
        f = lines_with_peaks(alone.model.band_hz, LINES, alone.structure.poles, self._known.poles)
        before = alone.frf(f, to, [at], sigma=False)
        return mobility_before_after(before, self._known.frf(f, to, [at]))

    def save(self, path: str | Path) -> Path:
        """Write the table as a CSV file; returns the path.

        Raises:
            StorageError: the file name has another ending, or the file cannot be written.
        """
        return write_rows(Path(path), modified_rows(self._known, []))

    def __repr__(self) -> str:
        hz = ", ".join(f"{f:.4g}" for f in self.frequency_hz)
        return f"<ChangedModel: {'; '.join(self._known.descriptions)}; modes at {hz} Hz>"

    def _repr_html_(self) -> str:
        return self.table().html()
