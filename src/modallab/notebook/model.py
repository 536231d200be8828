"""The modal model of a recording: found, shown, compared, kept."""

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Campaign
from modallab.core.digits import number_with_sigma, probability_text
from modallab.core.discovery import optional_package
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.identification.selection.criteria import mac
from modallab.modification.freedoms import with_points
from modallab.modification.known import KnownStructure
from modallab.notebook.arguments import path_for
from modallab.notebook.display import DisplayedTable
from modallab.notebook.model_behaviour import ModelBehaviour
from modallab.notebook.model_comparison import ModelComparison
from modallab.notebook.model_predictions import ModelPredictions
from modallab.pipelines.identify import CampaignResult, IdentifiedTest
from modallab.pipelines.model_file import write_models
from modallab.verification.comparison import common_shapes

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Model(ModelPredictions, ModelBehaviour, ModelComparison):
    """A modal model with its uncertainty; of several tests, that of the first. `model["sine"]` is that of another.

    Attributes:
        campaign: the recordings of the model.
        result: the models of all tests, with their verification.
        place: index of this model.
    """

    campaign: Campaign
    result: CampaignResult
    place: int = 0

    @property
    def identified_test(self) -> IdentifiedTest:
        """The test's model, its verification and its assessment."""
        return self.result.identified[self.place]

    @property
    def rig(self) -> Rig:
        """Rig of the records."""
        return self.campaign.rig

    @property
    def modal_model(self) -> ModalModel:
        """All arrays of the model, for all stages of modallab."""
        return self.identified_test.model

    @property
    def known_structure(self) -> KnownStructure:
        """The structure of the model, ready for predictions.

        Raises:
            DataError: an output or input has no point.
        """
        rig = self.campaign.rig
        return KnownStructure(with_points(self.modal_model, rig), rig)

    @property
    def measured_mobility(self) -> Frf:
        """Measured mobility of the verification.

        Raises:
            DataError: the method has no FRF.
        """
        return self.verification.measured

    @property
    def verification(self) -> Verification:
        """Measured beside regenerated mobility, with the FRAC of each pair.

        Raises:
            DataError: the method makes no FRF.
        """
        if self.identified_test.verification is None:
            raise DataError(
                f"the method {self.modal_model.method} regenerates no FRF",
                remedy="identify without method, or with refine=True",
            )
        return self.identified_test.verification

    @property
    def tests(self) -> tuple[str, ...]:
        """The tests that have a model."""
        return tuple(item.source for item in self.result.identified)

    def __getitem__(self, test: str) -> "Model":
        """The model of another test of the same recordings.

        Raises:
            DataError: it has none; the error says why.
        """
        if test in self.tests:
            return Model(self.campaign, self.result, self.tests.index(test))
        for item in self.result.unidentified:
            if item.source == test:
                raise item.error
        raise DataError(f"no test is called {test!r} here", remedy=f"use one of {', '.join(self.tests)}")

    def table(self) -> DisplayedTable:
        """Frequency and damping of every mode, with one standard deviation: 4.80(3) is 4.80 +- 0.03."""
        m, judged = self.modal_model, self.identified_test.assessment
        rows = [
            (
                str(r + 1),
                number_with_sigma(float(m.frequency_hz[r]), float(m.frequency_sigma_hz[r])),
                number_with_sigma(100 * float(m.damping_ratio[r]), 100 * float(m.damping_sigma[r])),
                ""
                if judged is None or not isfinite(judged.confidence[r])
                else probability_text(float(judged.confidence[r])),
            )
            for r in range(m.n_modes)
        ]
        return DisplayedTable(
            ("mode", "frequency [Hz]", "damping [%]", "confidence"), rows, f"{self.identified_test.source}, one sigma"
        )

    def plot_frf(self, drive: int = 0) -> "Figure":
        """Measured and regenerated FRFs of every output.

        Args:
            drive: index of the input.

        Raises:
            DataError: the method has no FRF to compare with, or there is no such input.
        """
        from modallab.reporting.figures.mobility import mobility_panels

        check = self.verification
        if drive not in range(len(self.modal_model.input_points)):
            raise DataError(
                f"there is no input {drive!r}", remedy=f"give drive from 0 to {len(self.modal_model.input_points) - 1}"
            )
        return mobility_panels(check, drive)

    def plot_shapes(self) -> "Figure":
        """The mode shapes with their uncertainty.

        Raises:
            DataError: the model has no shapes; the error says why.
        """
        from modallab.reporting.figures.mode_shapes import mode_shapes

        figure = mode_shapes([self.modal_model], self.campaign.rig)
        if figure is None:
            why = self.modal_model.shapes_unavailable or "the places of the outputs are unknown"
            raise DataError(
                f"there are no shapes to draw: {why}",
                remedy="name the points of inputs and outputs; one input must be at an output",
            )
        return figure

    def mac(self, other: "Model") -> Real:
        """(modes, modes of the other) modal assurance criterion over the common points.

        Raises:
            DataError: it is no model, or there are fewer than two common points.
        """
        if not isinstance(other, Model):
            raise DataError(f"{type(other).__name__} is no model", remedy="give what ml.identify gives")
        return mac(*common_shapes(self.modal_model, other.modal_model))

    def to_pandas(self) -> "pd.DataFrame":
        """A row for each mode: frequency, damping, their sigmas.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        m, pandas = self.modal_model, optional_package("pandas", "model.to_pandas()")
        columns = {
            "frequency_hz": m.frequency_hz,
            "frequency_sigma_hz": m.frequency_sigma_hz,
            "damping_ratio": m.damping_ratio,
            "damping_sigma": m.damping_sigma,
        }
        return pandas.DataFrame(columns, index=pandas.RangeIndex(1, m.n_modes + 1, name="mode"))

    def to_xarray(self) -> "xr.Dataset":
        """Labelled arrays: frequencies, damping, modal constants and, where known, shapes.

        Raises:
            MissingPackageError: xarray is not installed.
        """
        m, xarray = self.modal_model, optional_package("xarray", "model.to_xarray()")
        arrays: dict[str, tuple[tuple[str, ...], Any, dict[str, str]]] = {
            "frequency": (("mode",), m.frequency_hz, {"units": "Hz"}),
            "frequency_sigma": (("mode",), m.frequency_sigma_hz, {"units": "Hz"}),
            "damping_ratio": (("mode",), m.damping_ratio, {"units": "1"}),
            "damping_sigma": (("mode",), m.damping_sigma, {"units": "1"}),
            "modal_constant": (("mode", "output", "input"), m.modal_constants, {"units": "1/kg"}),
            "modal_constant_sigma": (("mode", "output", "input"), m.modal_constant_sigma, {"units": "1/kg"}),
        }
        if m.shapes is not None:
            arrays["shape"] = (("mode", "output"), m.shapes, {"units": "kg^-1/2"})
        coordinates = {"mode": np.arange(1, m.n_modes + 1), "output": list(m.outputs)}
        return xarray.Dataset(arrays, coordinates, {"method": m.method, "test": str(m.test or "frf")})

    def save(self, path: str | Path) -> Path:
        """Write the models of all tests as JSON, or the whole report if the name ends with .html; returns the path.

        Raises:
            StorageError: the file cannot be written, or its name has another ending.
        """
        path = path_for(path, (".json", ".html"))
        if path.suffix == ".html":
            from modallab.pipelines.report import report_content
            from modallab.reporting.report import write_report

            title = f"Modal test of {self.campaign.rig.name}"
            write_report(path, report_content(self.campaign, self.result, title))
        else:
            write_models(path, self.campaign, self.result)
        return path

    def __len__(self) -> int:
        return self.modal_model.n_modes

    def __repr__(self) -> str:
        hz = ", ".join(f"{f:.4g}" for f in self.modal_model.frequency_hz)
        return f"<Model of the {self.identified_test.source} test: {len(self)} modes at {hz} Hz>"

    def _repr_html_(self) -> str:
        return self.table().html()
