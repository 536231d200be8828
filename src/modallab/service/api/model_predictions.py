"""What a campaign's newest model predicts: FRFs, the motion that forces give, the state space."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from fastapi import Body, Depends, Query, Response
from fastapi.responses import FileResponse

from modallab.core.documents.model_use import (
    InitialMotionRequest,
    PredictedFrf,
    ResponseRequest,
    ResponseView,
    StateSpaceView,
)
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.units import Quantity, Test
from modallab.service.api.access import role_needed
from modallab.service.api.campaigns import BINARY, FILE, file_response
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import Motion, OfTest, Points, ServiceOf
from modallab.service.api.router import make_router
from modallab.service.campaigns.export import export_to_own_folder
from modallab.service.context import Service
from modallab.service.jobs.results import known_of_campaign

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from modallab.modification.structure import At

router = make_router("model-use")
MOST_SAMPLES = 100_000
"""Of a force by kind: more are computed beside the service, from its model."""


@dataclass(frozen=True, slots=True)
class FrfQuery:
    """FRFs between points, measured pairs or not, as a query names them.

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
    test: OfTest = None
    outputs: Points = None
    inputs: Points = None
    quantity: Annotated[FrfQuantity, Query(description="Of the FRFs.")] = "mobility"
    lines: Annotated[
        int,
        Query(
            ge=2,
            le=4000,
            description="Number of frequencies spread evenly over the band of the model; more are added about each "
            "mode.",
        ),
    ] = 1000
    residual_terms: Annotated[bool, Query(description="Whether to include residual terms.")] = True


FrfsOfQuery = Annotated[FrfQuery, Depends()]


@router.get("/campaigns/{campaign}/model/frf", responses=documented_responses(404))
def get_model_frf(service: ServiceOf, asked: FrfsOfQuery) -> PredictedFrf:
    """FRFs of the model between points, measured pairs or not, with their deviation."""
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


def _predicted_frf(service: Service, asked: FrfQuery) -> tuple[Test | None, Frf]:
    from modallab.modification.frfs import lines_with_peaks

    known = known_of_campaign(service, asked.campaign, asked.test)
    hz = lines_with_peaks(known.model.band_hz, asked.lines, known.poles)
    whole = known if asked.residual_terms else known.without_residual_terms
    return known.model.test, whole.frf(hz, asked.outputs, asked.inputs, asked.quantity)


@router.get(
    "/campaigns/{campaign}/model/frf/export",
    response_class=Response,
    responses={200: {"content": {FILE: {"schema": BINARY}}}} | documented_responses(404, 507),
)
def export_model_frf(
    service: ServiceOf,
    asked: FrfsOfQuery,
    to: Annotated[Literal["uff", "mat", "hdf5"], Query(description="UFF 58, MATLAB file, or campaign file.")] = "uff",
) -> FileResponse:
    """The same FRFs as a file for other programs; `mat` includes their deviation."""
    from modallab.formats.frf_file import rig_of, write_frf

    _, found = _predicted_frf(service, asked)
    file = f"{asked.campaign}-model{'.h5' if to == 'hdf5' else f'.{to}'}"
    return file_response(export_to_own_folder(service, file, lambda path: write_frf(path, found, rig_of(found))))


@router.post(
    "/campaigns/{campaign}/model/responses", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def predict_response(campaign: str, new: Annotated[ResponseRequest, Body()], service: ServiceOf) -> ResponseView:
    """Predict the motion under forces, with its deviation; nothing is stored."""
    from modallab.modification.motion import MotionOverTime

    known = known_of_campaign(service, campaign, new.test)
    start = _start_of_motion(new.start or ())
    found = MotionOverTime.of(known, _forces(new), new.step_s, new.at, new.of, new.quantity, new.between, start)
    figures, sigma = found.figures, found.figures_sigma
    return ResponseView(
        test=known.model.test,
        quantity=new.quantity,
        step_s=new.step_s,
        of=tuple(p[0] if isinstance(p, tuple) else p for p in found.points),
        values=found.values if new.samples else None,
        sigma=found.sigma if new.samples else None,
        peak=figures[:, 0],
        peak_sigma=sigma[:, 0],
        rms=figures[:, 1],
        rms_sigma=sigma[:, 1],
        octaves_hz=np.array(found.octaves_hz),
        levels=figures[:, 2:],
        levels_sigma=sigma[:, 2:],
        outside=found.outside,
    )


def _forces(new: ResponseRequest) -> "NDArray[np.float64]":
    """(forces, samples) N."""
    from modallab.modification.motion import force_samples

    if (new.forces_n is None) == (new.forces is None):
        raise DataError("give either `forces` or `forces_n`", where="forces", remedy="give forces_n or forces")
    if new.forces_n is not None:
        if len({len(force) for force in new.forces_n}) > 1:
            raise DataError("forces of several lengths", where="forces_n", remedy="give rows of one length")
        return np.array(new.forces_n)
    count = 0 if new.seconds is None else round(new.seconds / new.step_s)
    if not 2 <= count <= MOST_SAMPLES:
        raise DataError(f"{count} samples", where="seconds", remedy=f"give seconds for 2 to {MOST_SAMPLES} samples")
    return np.array([force_samples(force, new.step_s, count) for force in new.forces or ()])


def _start_of_motion(given: tuple[InitialMotionRequest, ...]) -> "dict[Quantity, dict[At, float]] | None":
    whole: dict[Quantity, dict[At, float]] = {
        "displacement": {one.at: one.displacement_m for one in given if one.displacement_m is not None},
        "velocity": {one.at: one.velocity_m_s for one in given if one.velocity_m_s is not None},
    }
    return {name: values for name, values in whole.items() if values} or None


@router.get("/campaigns/{campaign}/model/state-space", responses=documented_responses(404))
def get_state_space(
    campaign: str,
    at: Annotated[list[int], Query(max_length=100, description="Points of the forces; repeat for several.")],
    service: ServiceOf,
    test: OfTest = None,
    of: Points = None,
    quantity: Annotated[Motion, Query(description="Of the motion.")] = "acceleration",
) -> StateSpaceView:
    """Matrices A, B, C, D from forces in N to motions, of the modes alone."""
    known = known_of_campaign(service, campaign, test)
    found = known.state_space(at, of or known.sensors, quantity)
    return StateSpaceView(test=known.model.test, **dict(found))
