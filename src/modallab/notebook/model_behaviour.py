"""How a structure behaves: which modes make a response, where they move, what the motion looks like."""

from pathlib import Path
from typing import TYPE_CHECKING

from modallab.core.frf import Frf
from modallab.core.model import ModalModel, Verification
from modallab.core.units import Quantity
from modallab.modification.deflection import Deflection, mode_deflection, motion_in_space, operating_deflection
from modallab.modification.freedoms import freedoms_of
from modallab.modification.known import KnownStructure
from modallab.modification.nodes import AntinodesAndNodes, places_of_modes
from modallab.modification.participation import ModalParticipation, modal_participation
from modallab.modification.structure import At
from modallab.notebook.arguments import path_for
from modallab.notebook.display import DisplayedResult
from modallab.reporting.behaviour_table import deflection_rows, node_rows, participation_rows, reduction_rows
from modallab.verification.comparison import ModelReduction, reduction_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from modallab.core.rig import Rig
    from modallab.reporting.figures.deflection import Drawing


class DeflectionShape(DisplayedResult[Deflection]):
    """Amplitude and phase of every point at one frequency."""

    def __init__(self, numbers: Deflection, rig: "Rig") -> None:
        """With the places of a rig."""
        super().__init__(numbers, *deflection_rows(numbers))
        self._rig = rig

    def plot(self) -> "Figure":
        """The structure at its largest motion."""
        return self._drawing().figure

    def save(self, path: str | Path) -> Path:
        """Write an animation (.gif); returns the path.

        Raises:
            StorageError: the file name has another ending, or the file cannot be written.
        """
        path = path_for(path, (".gif",))
        self._drawing().save(path)
        return path

    def _drawing(self) -> "Drawing":
        from modallab.reporting.figures.deflection import Drawing

        return Drawing(self._rig, motion_in_space(self._rig, self.numbers), self.caption)


class ModelBehaviour:
    """Behaviour of a structure by its model."""

    __slots__ = ()

    @property
    def known_structure(self) -> KnownStructure:
        """The structure of the model."""
        raise NotImplementedError

    @property
    def measured_mobility(self) -> Frf:
        """Measured mobility."""
        raise NotImplementedError

    @property
    def modal_model(self) -> ModalModel:
        """Every array of the model."""
        raise NotImplementedError

    @property
    def verification(self) -> Verification:
        """Measured and regenerated FRFs."""
        raise NotImplementedError

    def reduction(self) -> DisplayedResult[ModelReduction]:
        """Count of the values in the measured FRFs and in the model, and the error of each measured pair.

        Raises:
            DataError: the method makes no FRF to compare with.
        """
        compared = self.verification
        found = reduction_of(self.modal_model, compared.measured.values, compared.regenerated.values, compared.frac)
        return DisplayedResult(found, *reduction_rows(found))

    def participation(
        self,
        at: At,
        of: At,
        band: tuple[float, float] | None = None,
        *,
        after_s: tuple[float, float] | None = None,
        quantity: Quantity = "velocity",
    ) -> DisplayedResult[ModalParticipation]:
        """Share of each mode in the response at a point, with its deviation.

        Args:
            at: point of the force.
            of: point of the motion.
            band: lower and upper edge in Hz of an even force; twice the same number for one frequency; None for the
                band of the model.
            after_s: instead of a band, begin and end in s of a time after a hit; twice the same number for an instant.
            quantity: displacement, velocity or acceleration.

        Raises:
            DataError: an impossible band or time, an unknown point, or no driving point.
        """
        found = modal_participation(self.known_structure, at, of, quantity, band, after_s)
        return DisplayedResult(found, *participation_rows(found, self.known_structure.model.frequency_hz.tolist()))

    def nodes(self) -> DisplayedResult[AntinodesAndNodes]:
        """Antinode and nodes of each mode: where to hit, and where to mount.

        Raises:
            DataError: no driving point, or an output or input without a point.
        """
        known = self.known_structure
        found = places_of_modes(known.structure, known.samples, known.model, known.rig)
        return DisplayedResult(found, *node_rows(found))

    def shape(self, mode: int) -> DeflectionShape:
        """The shape of a mode at unit modal mass, at every point that has a sensor or was driven.

        Args:
            mode: from 1.

        Raises:
            DataError: no such mode, no driving point, or no places of the points.
        """
        known = self.known_structure
        return DeflectionShape(mode_deflection(known.structure, known.samples, mode), known.stated_rig)

    def deflection(self, hz: float, at: int) -> DeflectionShape:
        """The operating deflection shape: motion per newton, from the measured FRFs at their line nearest to `hz`.

        Args:
            hz: frequency in Hz, within the FRFs.
            at: point of the force.

        Raises:
            DataError: no measured FRF, none from that point, or another frequency.
        """
        known = self.known_structure
        freedoms = freedoms_of(known.model, known.stated_rig)[0]
        return DeflectionShape(operating_deflection(self.measured_mobility, freedoms, hz, at), known.stated_rig)
