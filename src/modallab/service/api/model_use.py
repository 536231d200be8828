"""A campaign's newest model put to use: what makes a response, where modes move, FRFs, responses, changes."""

from typing import Annotated, Literal

from fastapi import Body, Depends, Query, Response
from fastapi.responses import FileResponse

from modallab.core.documents.model_change import ModificationNew, ModifiedView
from modallab.core.documents.model_other import (
    BestAbsorberNew,
    BestAbsorberView,
    ChangeForFreeBandNew,
    ChangeForFrequencyNew,
    ChangesForFreeBandView,
    ChangesForFrequencyView,
    CorrelationView,
)
from modallab.core.documents.model_understood import DeflectionView, NodesView, ParticipationView, ShapesView
from modallab.core.documents.model_update import UpdatedView, UpdateNew
from modallab.core.documents.model_use import (
    PredictedFrf,
    ResponseNew,
    ResponseView,
    StateSpaceView,
)
from modallab.core.errors import DataError
from modallab.core.frf import FrfQuantity
from modallab.core.units import Test
from modallab.service.api.campaigns import BINARY, FILE, file_response
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.roles import role_needed
from modallab.service.api.router import make_router
from modallab.service.jobs.model_frfs import FrfsAsked, export_predicted_frf, frf_of
from modallab.service.jobs.model_other import absorber_of, correlation_of, free_bands_of, tunings_of, updated_parameters
from modallab.service.jobs.model_understood import deflection_of, nodes_of, participation_of, shapes_of
from modallab.service.jobs.model_use import modified_modes_view, response_to, state_space_of_model

router = make_router("model-use")
OfTest = Annotated[Test | None, Query(description="Whose model; left out: the first.")]
At = Annotated[int, Query(ge=1, description="Point of the force.")]
Hz = Annotated[float | None, Query(gt=0, allow_inf_nan=False, description="Edge of the band; left out: the model's.")]
Seconds = Annotated[
    float | None,
    Query(
        ge=0,
        le=1e6,
        allow_inf_nan=False,
        description="Of a time after a hit, instead of a band; one number for both is an instant.",
    ),
]
Points = Annotated[list[int] | None, Query(max_length=100, description="Points; repeat it for several.")]
Motion = Literal["displacement", "velocity", "acceleration"]


def frfs_of_query(
    campaign: str,
    test: OfTest = None,
    outputs: Points = None,
    inputs: Points = None,
    quantity: Annotated[FrfQuantity, Query(description="Of the FRFs.")] = "mobility",
    lines: Annotated[
        int, Query(ge=2, le=4000, description="Evenly over the band of the model; more are added about each mode.")
    ] = 1000,
    residual_terms: Annotated[bool, Query(description="Whether what lies outside the band counts.")] = True,
) -> FrfsAsked:
    """FRFs as the query names them."""
    return FrfsAsked(campaign, test, outputs, inputs, quantity, lines, residual_terms)


FrfsOfQuery = Annotated[FrfsAsked, Depends(frfs_of_query)]


@router.get("/campaigns/{campaign}/model/participation", responses=documented_responses(404))
def get_participation(
    campaign: str,
    at: At,
    of: Annotated[int, Query(ge=1, description="Point of the motion.")],
    service: ServiceOf,
    test: OfTest = None,
    low_hz: Hz = None,
    high_hz: Hz = None,
    begin_s: Seconds = None,
    end_s: Seconds = None,
    quantity: Annotated[Motion, Query(description="Of the motion.")] = "velocity",
) -> ParticipationView:
    """Which modes make the response at a point to an even force, or after a hit: the share of each."""
    band, after = both_or_neither("low_hz, high_hz", low_hz, high_hz), both_or_neither("begin_s, end_s", begin_s, end_s)
    return participation_of(service, campaign, test, at, of, quantity, band, after)


def both_or_neither(where: str, low: float | None, high: float | None) -> tuple[float, float] | None:
    """Two ends, or none.

    Raises:
        DataError: one of them is missing.
    """
    if (low is None) != (high is None):
        raise DataError(f"one of {where} is missing", where=where, remedy="give both, or neither")
    return None if low is None or high is None else (low, high)


@router.get("/campaigns/{campaign}/model/nodes", responses=documented_responses(404))
def get_nodes(campaign: str, service: ServiceOf, test: OfTest = None) -> NodesView:
    """Where each mode moves most and where its nodes are: where to hit, where to mount."""
    return nodes_of(service, campaign, test)


@router.get("/campaigns/{campaign}/model/shapes", responses=documented_responses(404))
def get_shapes(campaign: str, service: ServiceOf, test: OfTest = None) -> ShapesView:
    """The structure as points and lines, and how it moves in each mode."""
    return shapes_of(service, campaign, test)


@router.get("/campaigns/{campaign}/model/deflection", responses=documented_responses(404))
def get_deflection(
    campaign: str,
    hz: Annotated[float, Query(gt=0, allow_inf_nan=False, description="Frequency in Hz.")],
    at: At,
    service: ServiceOf,
    test: OfTest = None,
) -> DeflectionView:
    """The operating deflection shape that the measured FRFs show at their line nearest to a frequency."""
    return deflection_of(service, campaign, test, hz, at)


@router.get("/campaigns/{campaign}/model/frf", responses=documented_responses(404))
def get_model_frf(service: ServiceOf, asked: FrfsOfQuery) -> PredictedFrf:
    """FRFs of the model between points, measured pairs or not, with their deviation."""
    return frf_of(service, asked)


@router.get(
    "/campaigns/{campaign}/model/frf/export",
    response_class=Response,
    responses={200: {"content": {FILE: {"schema": BINARY}}}} | documented_responses(404, 507),
)
def export_model_frf(
    service: ServiceOf,
    asked: FrfsOfQuery,
    to: Annotated[Literal["uff", "mat", "hdf5"], Query(description="UFF 58, MATLAB's, or a campaign file.")] = "uff",
) -> FileResponse:
    """The same FRFs as a file that other programs read; `mat` holds their deviation."""
    ending = {"uff": ".uff", "mat": ".mat", "hdf5": ".h5"}[to]
    return file_response(export_predicted_frf(service, asked, ending))


@router.post(
    "/campaigns/{campaign}/model/modifications",
    responses=documented_responses(404),
    openapi_extra=role_needed("observer"),
)
def modify_model(campaign: str, new: Annotated[ModificationNew, Body()], service: ServiceOf) -> ModifiedView:
    """Predict the modes after changes of the structure; nothing is kept."""
    return modified_modes_view(service, campaign, new)


@router.post(
    "/campaigns/{campaign}/model/responses", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def predict_response(campaign: str, new: Annotated[ResponseNew, Body()], service: ServiceOf) -> ResponseView:
    """Predict the motion that forces give, with its deviation; nothing is kept."""
    return response_to(service, campaign, new)


@router.get("/campaigns/{campaign}/model/state-space", responses=documented_responses(404))
def get_state_space(
    campaign: str,
    at: Annotated[list[int], Query(max_length=100, description="Points of the forces; repeat it for several.")],
    service: ServiceOf,
    test: OfTest = None,
    of: Points = None,
    quantity: Annotated[Motion, Query(description="Of the motion.")] = "acceleration",
) -> StateSpaceView:
    """Matrices A, B, C, D from forces in N to motions, of the modes alone."""
    return state_space_of_model(service, campaign, test, at, of, quantity)


@router.get("/campaigns/{campaign}/model/correlation", responses=documented_responses(404))
def get_correlation(
    campaign: str,
    other: Annotated[str, Query(description="Campaign of the other model.")],
    service: ServiceOf,
    test: OfTest = None,
    other_test: Annotated[Test | None, Query(description="Of the other campaign; left out: the first.")] = None,
) -> CorrelationView:
    """Which modes of two campaigns' models are the same: pairs by MAC, frequencies, damping, COMAC."""
    return correlation_of(service, campaign, test, other, other_test)


@router.post(
    "/campaigns/{campaign}/model/tunings", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def tune_model(
    campaign: str, new: Annotated[ChangeForFrequencyNew, Body()], service: ServiceOf
) -> ChangesForFrequencyView:
    """Find the mass or spring that brings a mode to a frequency, at each point; nothing is kept."""
    return tunings_of(service, campaign, new)


@router.post(
    "/campaigns/{campaign}/model/free-bands", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def free_band(
    campaign: str, new: Annotated[ChangeForFreeBandNew, Body()], service: ServiceOf
) -> ChangesForFreeBandView:
    """Find the mass or spring that leaves no mode in a band, at each point; nothing is kept."""
    return free_bands_of(service, campaign, new)


@router.post(
    "/campaigns/{campaign}/model/absorbers", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def find_absorber(campaign: str, new: Annotated[BestAbsorberNew, Body()], service: ServiceOf) -> BestAbsorberView:
    """Find the absorber of a mass that leaves the least peak about a mode; nothing is kept."""
    return absorber_of(service, campaign, new)


@router.post(
    "/campaigns/{campaign}/model/updates", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def update_finite_elements(campaign: str, new: Annotated[UpdateNew, Body()], service: ServiceOf) -> UpdatedView:
    """Estimate the parameters of a finite-element model, or of the rig file's beam; nothing is kept."""
    return updated_parameters(service, campaign, new)
