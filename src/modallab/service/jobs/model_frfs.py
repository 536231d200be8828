"""FRFs of a campaign's newest model, as a document and as a file."""

from dataclasses import dataclass

import numpy as np

from modallab.core.documents.model_use import PredictedFrf
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.units import Test
from modallab.service.campaigns.export import ExportedFile, export_to_own_folder
from modallab.service.context import Service
from modallab.service.jobs.model_use import known_of_campaign


@dataclass(frozen=True, slots=True)
class FrfsAsked:
    """FRFs between points, measured pairs or not.

    Attributes:
        campaign: whose newest model.
        test: of which; None for the first.
        outputs: points of the motion; None for all with a sensor.
        inputs: points of the force; None for those driven.
        quantity: receptance, mobility or inertance.
        lines: evenly over the band.
        residual_terms: whether what lies outside the band counts.
    """

    campaign: str
    test: Test | None
    outputs: list[int] | None
    inputs: list[int] | None
    quantity: FrfQuantity
    lines: int
    residual_terms: bool


def frf_of(service: Service, asked: FrfsAsked) -> PredictedFrf:
    """FRFs as a document.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a point that the model does not know, or no driving point.
    """
    of_test, found = _predicted_frf(service, asked)
    assert found.variance is not None
    return PredictedFrf(
        test=of_test,
        quantity=asked.quantity,
        frequency_hz=found.frequency_hz,
        outputs=tuple(p or 0 for p in found.output_points),
        inputs=tuple(p or 0 for p in found.input_points),
        values=found.values,
        sigma=np.sqrt(found.variance),
    )


def _predicted_frf(service: Service, asked: FrfsAsked) -> tuple[Test | None, Frf]:
    from modallab.modification.frfs import lines_with_peaks

    known = known_of_campaign(service, asked.campaign, asked.test)
    hz = lines_with_peaks(known.model.band_hz, asked.lines, known.poles)
    whole = known if asked.residual_terms else known.without_residual_terms
    return known.model.test, whole.frf(hz, asked.outputs, asked.inputs, asked.quantity)


def export_predicted_frf(service: Service, asked: FrfsAsked, ending: str) -> ExportedFile:
    """FRFs as a file that other programs read: .uff, .mat or .h5.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a point that the model does not know, or no driving point.
        StorageError: the file cannot be written.
    """
    from modallab.formats.frf_file import rig_of, write_frf

    _, found = _predicted_frf(service, asked)
    return export_to_own_folder(
        service, f"{asked.campaign}-model{ending}", lambda path: write_frf(path, found, rig_of(found))
    )
