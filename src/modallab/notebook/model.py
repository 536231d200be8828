"""The modal model of a recording: found, shown, compared, kept."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.digits import concise, probability
from modallab.core.errors import DataError, IdentificationError
from modallab.core.extras import optional_package
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.units import FrfEstimator, Test
from modallab.core.verification import Verification
from modallab.identification.estimator import USUAL
from modallab.identification.options import Options
from modallab.identification.selection.criteria import mac
from modallab.modification.correlation import Correlation, correlate
from modallab.modification.known import Known
from modallab.notebook.arguments import band_of, frequencies_of, path_for
from modallab.notebook.measured import MeasuredFrf, phase_rises
from modallab.notebook.put_to_use import PutToUse
from modallab.notebook.recording import Recording
from modallab.notebook.shown import Answered, Shown
from modallab.notebook.understood import Understood
from modallab.pipelines.identify import Identified, Result
from modallab.pipelines.model_file import write_models
from modallab.pipelines.model_use import known_of
from modallab.pipelines.response_only import USUAL_RESPONSE, ResponseMethod, identify_chosen
from modallab.pipelines.response_setups import identify_response_setups
from modallab.pipelines.setups import identify_setups
from modallab.pipelines.structure_gap import read_reference
from modallab.reporting.understood_table import correlation_rows
from modallab.reporting.waiting import waiting
from modallab.verification.comparison import common_shapes

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Model(PutToUse, Understood):
    """A modal model with its uncertainty; of several tests, that of the first. `model["sine"]` is that of another.

    Attributes:
        campaign: the recordings it came from.
        result: the models of all tests, with what was verified.
        place: which of them this is.
    """

    campaign: Campaign
    result: Result
    place: int = 0

    @property
    def found(self) -> Identified:
        """The test's model, its verification and its assessment."""
        return self.result.identified[self.place]

    @property
    def modal(self) -> ModalModel:
        """Every array of the model, as every stage of modallab takes it."""
        return self.found.model

    @property
    def known(self) -> Known:
        """The structure that the model describes, ready for use.

        Raises:
            DataError: no sensor stands at a driven point, or an output or input has no point.
        """
        return known_of(self.campaign, self.modal)

    @property
    def measured(self) -> Frf:
        """The measured mobility that the model was compared with.

        Raises:
            DataError: the method makes no FRF.
        """
        return self._verification.measured

    @property
    def _verification(self) -> Verification:
        if self.found.verification is None:
            raise DataError(
                f"the method {self.modal.method} regenerates no FRF",
                remedy="identify without method, or with refine=True",
            )
        return self.found.verification

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

    def table(self) -> Shown:
        """Frequency and damping of every mode, with one standard deviation: 4.80(3) is 4.80 +- 0.03."""
        m, judged = self.modal, self.found.assessment
        rows = [
            (
                str(r + 1),
                concise(float(m.frequency_hz[r]), float(m.frequency_sigma_hz[r])),
                concise(100 * float(m.damping_ratio[r]), 100 * float(m.damping_sigma[r])),
                ""
                if judged is None or not isfinite(judged.confidence[r])
                else probability(float(judged.confidence[r])),
            )
            for r in range(m.n_modes)
        ]
        return Shown(("mode", "frequency [Hz]", "damping [%]", "confidence"), rows, f"{self.found.source}, one sigma")

    def plot_frf(self, drive: int = 0) -> "Figure":
        """Measured and regenerated FRFs of every output.

        Args:
            drive: which of the inputs.

        Raises:
            DataError: the method makes no FRF to compare with, or there is no such input.
        """
        from modallab.reporting.figures.all_points import all_points

        check = self._verification
        if drive not in range(len(self.modal.input_points)):
            raise DataError(
                f"there is no input {drive!r}", remedy=f"give drive from 0 to {len(self.modal.input_points) - 1}"
            )
        return all_points(check, drive)

    def plot_shapes(self) -> "Figure":
        """The mode shapes with their uncertainty.

        Raises:
            DataError: the model has no shapes; the error says why.
        """
        from modallab.reporting.figures.mode_shapes import mode_shapes

        figure = mode_shapes([self.modal], self.campaign.rig)
        if figure is None:
            why = self.modal.shapes_unavailable or "the places of the outputs are unknown"
            raise DataError(
                f"there are no shapes to draw: {why}",
                remedy="name the points of inputs and outputs; one input must be at an output",
            )
        return figure

    def mac(self, other: "Model") -> Real:
        """(modes, modes of the other) modal assurance criterion over the points that both have.

        Raises:
            DataError: it is no model, or they share fewer than two points.
        """
        if not isinstance(other, Model):
            raise DataError(f"{type(other).__name__} is no model", remedy="give what ml.identify gives")
        return mac(*common_shapes(self.modal, other.modal))

    def correlation(self, other: "Model | str | Path") -> Answered[Correlation]:
        """Beside another model of the structure: pairs by MAC, their frequencies and damping, COMAC.

        Args:
            other: a model, or a file of models or of a finite-element model, which is taken at the points of this one.

        Raises:
            DataError: fewer than two common points, no driving point, or no two modes that are alike.
            FormatError: the file can be read as neither.
        """
        if isinstance(other, Model):
            known = other.known
        else:
            known = Known(read_reference(Path(other), self.campaign.rig, self.modal)[0], self.campaign.rig)
        found = correlate(self.known, known)
        return Answered(found, *correlation_rows(found))

    def to_pandas(self) -> "pd.DataFrame":
        """A row for each mode: frequency, damping, their sigmas.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        m, pandas = self.modal, optional_package("pandas", "model.to_pandas()")
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
        m, xarray = self.modal, optional_package("xarray", "model.to_xarray()")
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
            StorageError: the file cannot be written, or its name ends otherwise.
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
        return self.modal.n_modes

    def __repr__(self) -> str:
        hz = ", ".join(f"{f:.4g}" for f in self.modal.frequency_hz)
        return f"<Model of the {self.found.source} test: {len(self)} modes at {hz} Hz>"

    def _repr_html_(self) -> str:
        return self.table().html()


def identify(
    measured: Recording | MeasuredFrf | list[Recording] | tuple[Recording, ...],
    test: Test | None = None,
    *,
    band: tuple[float, float] | None = None,
    method: str = USUAL,
    pick: tuple[float, ...] = (),
    drop: tuple[float, ...] = (),
    refine: bool | None = None,
    frf: FrfEstimator = "H1",
    response_only: bool | None = None,
    response_method: ResponseMethod = USUAL_RESPONSE,
    progress: bool = True,
) -> Model:
    """The modal model of recordings or FRFs.

    Args:
        measured: what `simulate`, `load`, `frf` or `responses` gave; several recordings are set-ups of one test, and
            are joined.
        test: only this test; None for all there are.
        band: in Hz; None for all that the data hold.
        method: name of the estimator.
        pick: frequencies in Hz of the modes to keep, by hand; the others are left out.
        drop: frequencies in Hz of modes to leave out.
        refine: whether a maximum-likelihood search follows; None for what is usual with the method.
        frf: how FRFs are made of blocks: H2 takes the force for noisy and the responses for exact, Hv stands between it
            and H1; of random drives, chirps, and several hits at each point.
        response_only: whether the force is left out, and taken for random; None for where none was measured. Shapes
            then have no scale: `modal.operating_shapes`, 1 at the largest.
        response_method: how modes of the responses alone are found.
        progress: show how far it is, where somebody looks.

    Raises:
        DataError: there is nothing to identify.
        IdentificationError: no mode stands out, or a parameter that cannot be.
    """
    options = Options(
        method=method,
        band_hz=band_of(band),
        pick_hz=frequencies_of(pick, "pick"),
        drop_hz=frequencies_of(drop, "drop"),
        refine=refine,
        frf=frf,
    )
    if isinstance(measured, list | tuple):
        with waiting("identifying", progress=progress):
            return _joined(measured, options, test, response_only, response_method)
    campaign = campaign_in(measured)
    try:
        with waiting("identifying", progress=progress):
            result = identify_chosen(campaign, options, test, response_only=response_only, method=response_method)
            return Model(campaign, result)
    except IdentificationError as error:
        if any(phase_rises(frf) for frf in campaign.frfs):
            raise IdentificationError(
                f"{error.what}; and the phase of H rises through its peaks, as it never does for exp(+i omega t)",
                remedy="give H.conj()",
            ) from error
        raise


def _joined(
    measured: Sequence[Recording],
    options: Options,
    test: Test | None,
    response_only: bool | None,
    method: ResponseMethod,
) -> Model:
    campaigns = [campaign_in(one) for one in measured]
    alone = all(c.rig.force is None for c in campaigns) if response_only is None else response_only
    if alone:
        merged = identify_response_setups(campaigns, options, test, method)
        return Model(merged.campaign, merged.result)
    joined = identify_setups(campaigns, options)
    return Model(joined.campaign, joined.result)


def campaign_in(measured: object) -> Campaign:
    """The campaign of what `simulate`, `load` or `frf` gave.

    Raises:
        DataError: it is neither.
    """
    if isinstance(measured, Recording | MeasuredFrf):
        return measured.campaign
    if isinstance(measured, Campaign):
        return measured
    hint = f"ml.load({str(measured)!r})" if isinstance(measured, str | Path) else "ml.frf(f, H) for arrays"
    raise DataError(f"{type(measured).__name__} is no recording", remedy=f"give what ml.load gives: {hint}")
