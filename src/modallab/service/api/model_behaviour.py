"""What a campaign's newest model says of how its structure behaves: what makes a response, where modes move."""

from typing import Annotated

import numpy as np
from fastapi import Query

from modallab.core.documents.model_behaviour import (
    DeflectionView,
    NodesView,
    NodeView,
    ParticipationView,
    ReductionView,
    ShapesView,
)
from modallab.core.documents.models import TestCurves
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.frozen import ComplexArray
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import Motion, OfTest, ServiceOf
from modallab.service.api.router import make_router
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.results import curves_of_campaign, known_of_campaign, model_of_campaign

router = make_router("model-use")
At = Annotated[int, Query(ge=1, description="Point of the force.")]
Hz = Annotated[
    float | None, Query(gt=0, allow_inf_nan=False, description="Edge of the band (default: that of the model).")
]
Seconds = Annotated[
    float | None,
    Query(
        ge=0,
        le=1e6,
        allow_inf_nan=False,
        description="Begin or end of a time after a hit, instead of a band; equal numbers are an instant.",
    ),
]


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
    """The share of each mode in the response at a point, to an even force or after a hit."""
    from modallab.modification.participation import modal_participation

    band, after = (
        _both_or_neither("low_hz, high_hz", low_hz, high_hz),
        _both_or_neither("begin_s, end_s", begin_s, end_s),
    )
    known = known_of_campaign(service, campaign, test)
    found = modal_participation(known, at, of, quantity, band, after)
    return ParticipationView.of_fields(known.model, found, at=at, of=of, quantity=quantity)


def _both_or_neither(where: str, low: float | None, high: float | None) -> tuple[float, float] | None:
    """Two ends, or none."""
    if (low is None) != (high is None):
        raise DataError(f"one of {where} is missing", where=where, remedy="give both, or neither")
    return None if low is None or high is None else (low, high)


@router.get("/campaigns/{campaign}/model/nodes", responses=documented_responses(404))
def get_nodes(campaign: str, service: ServiceOf, test: OfTest = None) -> NodesView:
    """Antinode and nodes of each mode: where to hit, where to mount."""
    from modallab.modification.nodes import places_of_modes
    from modallab.reporting.behaviour_table import advice_of

    known = known_of_campaign(service, campaign, test)
    found = places_of_modes(known.structure, known.samples, known.model, known.rig)
    return NodesView.of_fields(
        found,
        test=known.model.test,
        points=tuple(point for point, _ in found.freedoms),
        axes=tuple(axis for _, axis in found.freedoms),
        antinode=tuple(point for point, _ in found.antinode),
        near_node=tuple(tuple(point for point, _ in near) for near in found.nodes),
        crossings=tuple(NodeView(mode=c.mode + 1, place_m=c.place_m, place_sigma_m=c.sigma_m) for c in found.crossings),
        advice=tuple(advice_of(found)),
    )


@router.get("/campaigns/{campaign}/model/reduction", responses=documented_responses(404))
def get_reduction(campaign: str, service: ServiceOf, test: OfTest = None) -> ReductionView:
    """Count of the values in the measured FRFs and in the model, and the error of each pair."""
    from modallab.verification.comparison import reduction_of

    one = model_of_campaign(service, campaign, test)
    _, measured, regenerated = _measured_of(service, campaign, one.model.test)
    found = reduction_of(one.model, measured, regenerated, np.array(one.frac, dtype=float))
    return ReductionView(
        test=one.model.test,
        outputs=found.outputs,
        output_points=found.output_points,
        input_points=found.input_points,
        measured_numbers=found.measured_numbers,
        model_numbers=found.model_numbers,
        error=found.error,
        frac=found.frac,
    )


def _measured_of(service: Service, campaign: str, test: str | None) -> tuple[TestCurves, ComplexArray, ComplexArray]:
    """The model of a test with its measured and regenerated FRFs."""
    curves = next(c for c in curves_of_campaign(service, campaign).tests if c.test == test)
    if curves.measured is None or curves.regenerated is None:
        raise NotFoundError(f"campaign {campaign} has no measured FRF of this test", remedy="name another test")
    return curves, curves.measured, curves.regenerated


@router.get("/campaigns/{campaign}/model/shapes", responses=documented_responses(404))
def get_shapes(campaign: str, service: ServiceOf, test: OfTest = None) -> ShapesView:
    """The structure as points and lines, and its motion in each mode."""
    from modallab.modification.mesh import Wireframe, motion_of, motion_without_scale

    found = model_of_campaign(service, campaign, test)
    rig = service.store.catalogue.run(found.runs[0]).rig
    try:
        known = known_of_campaign(service, campaign, test)
        motion = motion_of(known.structure, rig, known.structure.psi)
    except DataError:
        motion = motion_without_scale(found.model, rig)
    skeleton = Wireframe.of(rig)
    return ShapesView.of_fields(found.model, skeleton, motion=motion)


@router.get("/campaigns/{campaign}/model/deflection", responses=documented_responses(404))
def get_deflection(
    campaign: str,
    hz: Annotated[float, Query(gt=0, allow_inf_nan=False, description="Frequency in Hz.")],
    at: At,
    service: ServiceOf,
    test: OfTest = None,
) -> DeflectionView:
    """The operating deflection shape from the measured FRFs, at the line nearest to a frequency."""
    from modallab.modification.deflection import operating_deflection
    from modallab.modification.freedoms import freedoms_of

    known = known_of_campaign(service, campaign, test)
    if known.rig is None:
        raise NotFoundError(f"campaign {campaign} has no measured FRF of this test", remedy="name another test")
    curves, measured, _ = _measured_of(service, campaign, known.model.test)
    points = curves.outputs, curves.output_points, curves.input_points
    variance = None if curves.sigma is None else curves.sigma**2
    frf = Frf(curves.frequency_hz, measured, "mobility", *points, variance=variance)
    found = operating_deflection(frf, freedoms_of(known.model, known.rig)[0], hz, at)
    return DeflectionView(
        test=known.model.test,
        frequency_hz=found.frequency_hz,
        at=at,
        points=tuple(point for point, _ in found.freedoms),
        axes=tuple(axis for _, axis in found.freedoms),
        values=found.values.astype(np.complex128),
        sigma=found.sigma,
    )
