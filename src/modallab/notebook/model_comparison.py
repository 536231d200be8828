"""A measured model beside other models of its structure: which modes are the same, and what corrects the other."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.fem.matrix_model import MatrixModel
from modallab.modification.known import KnownStructure
from modallab.notebook.display import DisplayedResult, DisplayedTable
from modallab.notebook.model_predictions import ModelPredictions
from modallab.pipelines.model_update import update_model
from modallab.pipelines.structure_gap import read_reference
from modallab.reporting.behaviour_table import correlation_rows
from modallab.reporting.modification_table import parameter_rows, updated_mode_rows
from modallab.updating.correlation import ModelCorrelation, correlate_models
from modallab.updating.result import Prior, UpdatedParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class UpdatedModel(DisplayedResult[UpdatedParameters]):
    """Parameters of a model with their 95 % intervals; `numbers` holds all arrays."""

    def __init__(self, numbers: UpdatedParameters) -> None:
        super().__init__(numbers, *parameter_rows(numbers))

    @property
    def values(self) -> dict[str, float]:
        """Parameter -> the most probable value."""
        return self.numbers.numbers

    def modes(self) -> DisplayedTable:
        """Each measured mode beside the model's, before and after."""
        return DisplayedTable(*updated_mode_rows(self.numbers))


class CorrelatedModes(DisplayedResult[ModelCorrelation]):
    """Pairs of modes of two models; `numbers` holds all arrays."""

    def __init__(self, numbers: ModelCorrelation, rig: Rig | None) -> None:
        super().__init__(numbers, *correlation_rows(numbers))
        self._rig = rig

    def plot(self) -> "Figure":
        """The shapes of each pair over each other.

        Raises:
            DataError: the places of the points are not known.
        """
        from modallab.reporting.figures.mode_shapes import paired_shapes

        if self._rig is None:
            raise DataError("the places of the points are not known", remedy="identify a campaign with its rig file")
        return paired_shapes(self.numbers, self._rig)


class ModelComparison:
    """Comparison of a measured model with another model of its structure."""

    __slots__ = ()

    @property
    def known_structure(self) -> KnownStructure:
        """The structure of the model."""
        raise NotImplementedError

    def correlation(self, other: ModelPredictions | str | Path) -> CorrelatedModes:
        """Correlation with another model of the structure: pairs by MAC, their frequencies and damping, COMAC.

        Args:
            other: a model, or a file of models or of a finite-element model, interpolated to the points of this model.

        Raises:
            DataError: fewer than two common points, no driving point, or no pair of modes.
            FormatError: the file has an unknown format.
        """
        if isinstance(other, ModelPredictions):
            known = other.known_structure
        else:
            rig = self.known_structure.stated_rig
            known = KnownStructure(read_reference(Path(other), rig, self.known_structure.model).model, rig)
        return CorrelatedModes(correlate_models(self.known_structure, known), self.known_structure.rig)

    def update(
        self,
        model: MatrixModel | Callable[..., Any] | str | Path | None = None,
        priors: Mapping[str, Prior] | None = None,
        held_out: Sequence[int] = (),
    ) -> UpdatedModel:
        """Estimate the parameters of a model of the structure, such as E or a spring, from this test.

        Args:
            model: `ml.MatrixModel`, a file of matrices with parameters, or a function; None for the rig's beam. A
                function takes numbers by name. It gives frequencies (modes,) in Hz, and shapes (modes, points) at
                unit modal mass.
            priors: parameter -> `ml.Prior`, besides those of the model.
            held_out: modes, from 1, that only check the estimate.

        Raises:
            DataError: no such parameter or mode, no driving point, or a model without the points of the test.
            FormatError: the file holds no matrices.
        """
        of = Path(model) if isinstance(model, str | Path) else model
        return UpdatedModel(update_model(self.known_structure, of, priors, held_out))
