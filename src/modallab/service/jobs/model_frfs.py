"""FRFs of a campaign's newest model, as a document and as a file."""

import numpy as np

from modallab.core.documents.model_use import PredictedFrf
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.units import Test
from modallab.service.campaigns.export import ExportedFile, export_to_own_folder
from modallab.service.context import Service
from modallab.service.jobs.model_use import known_of_campaign


def frf_of(
    service: Service,
    campaign: str,
    test: Test | None,
    outputs: list[int] | None,
    inputs: list[int] | None,
    quantity: FrfQuantity,
    lines: int,
) -> PredictedFrf:
    """FRFs between points, measured pairs or not.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a point that the model does not know, or no driving point.
    """
    of_test, found = _predicted_frf(service, campaign, test, outputs, inputs, quantity, lines)
    assert found.variance is not None
    return PredictedFrf(
        test=of_test,
        quantity=quantity,
        frequency_hz=found.frequency_hz,
        outputs=tuple(p or 0 for p in found.output_points),
        inputs=tuple(p or 0 for p in found.input_points),
        values=found.values,
        sigma=np.sqrt(found.variance),
    )


def _predicted_frf(
    service: Service,
    campaign: str,
    test: Test | None,
    outputs: list[int] | None,
    inputs: list[int] | None,
    quantity: FrfQuantity,
    lines: int,
) -> tuple[Test | None, Frf]:
    from modallab.modification.frfs import lines_with_peaks

    known = known_of_campaign(service, campaign, test)
    hz = lines_with_peaks(known.model.band_hz, lines, known.poles)
    return known.model.test, known.frf(hz, outputs, inputs, quantity)


def export_predicted_frf(
    service: Service,
    campaign: str,
    test: Test | None,
    outputs: list[int] | None,
    inputs: list[int] | None,
    quantity: FrfQuantity,
    lines: int,
    ending: str,
) -> ExportedFile:
    """FRFs between points as a file that other programs read.

    Args:
        service: where the campaign is.
        campaign: its id.
        test: whose model; None for the first.
        outputs: points of the motion; None for all with a sensor.
        inputs: points of the force; None for those driven.
        quantity: receptance, mobility or inertance.
        lines: evenly over the band.
        ending: of the file: .uff, .mat or .h5.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a point that the model does not know, or no driving point.
        StorageError: the file cannot be written.
    """
    from modallab.formats.frf_file import rig_of, write_frf

    _, found = _predicted_frf(service, campaign, test, outputs, inputs, quantity, lines)
    return export_to_own_folder(
        service, f"{campaign}-model{ending}", lambda path: write_frf(path, found, rig_of(found))
    )
