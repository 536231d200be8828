"""What a campaign's newest model says of how its structure behaves."""

import numpy as np

from modallab.core.documents.model_understood import (
    CrossingView,
    DeflectionView,
    NodesView,
    ParticipationView,
    ShapesView,
)
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.units import Quantity, Test
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.model_use import known_of_campaign, model_of_campaign
from modallab.service.jobs.results import curves_of_campaign


def shapes_of(service: Service, campaign: str, test: Test | None) -> ShapesView:
    """The structure, and how it moves in each mode: at driven points too where the model has a driving point.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: an output has no point.
    """
    from modallab.modification.skeleton import Skeleton, motion_of, motion_without_scale

    found = model_of_campaign(service, campaign, test)
    rig = service.store.catalogue.run(found.runs[0]).rig
    try:
        known = known_of_campaign(service, campaign, test)
        motion = motion_of(known.structure, rig, known.structure.psi)
    except DataError:
        motion = motion_without_scale(found.model, rig)
    skeleton = Skeleton.of(rig)
    return ShapesView(
        test=found.model.test,
        frequency_hz=found.model.frequency_hz,
        points=skeleton.points,
        places_m=skeleton.places_m,
        lines=skeleton.lines,
        surfaces=skeleton.surfaces,
        motion=motion,
    )


def participation_of(
    service: Service,
    campaign: str,
    test: Test | None,
    at: int,
    of: int,
    quantity: Quantity,
    band_hz: tuple[float, float] | None,
    after_s: tuple[float, float] | None,
) -> ParticipationView:
    """Which modes make the response at a point, over a band or a time after a hit.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a band outside the model's, a time that cannot be, a point that it does not know, or no driving
            point.
    """
    from modallab.modification.participation import modal_participation

    known = known_of_campaign(service, campaign, test)
    found = modal_participation(known, at, of, quantity, band_hz, after_s)
    return ParticipationView(
        test=known.model.test,
        at=at,
        of=of,
        quantity=quantity,
        band_hz=found.band_hz,
        after_s=found.after_s,
        frequency_hz=known.model.frequency_hz,
        share=found.share,
        share_sigma=found.share_sigma,
        alone=found.alone,
        outside=found.outside,
    )


def nodes_of(service: Service, campaign: str, test: Test | None) -> NodesView:
    """Where each mode moves most and where its nodes are.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no driving point.
    """
    from modallab.modification.nodes import places_of_modes
    from modallab.reporting.understood_table import advice_of

    known = known_of_campaign(service, campaign, test)
    found = places_of_modes(known.structure, known.samples, known.model, known.rig)
    return NodesView(
        test=known.model.test,
        frequency_hz=found.frequency_hz,
        points=tuple(point for point, _ in found.freedoms),
        axes=tuple(axis for _, axis in found.freedoms),
        motion=found.motion,
        motion_sigma=found.motion_sigma,
        antinode=tuple(point for point, _ in found.antinode),
        near_node=tuple(tuple(point for point, _ in near) for near in found.nodes),
        crossings=tuple(
            CrossingView(mode=c.mode + 1, place_m=c.place_m, place_sigma_m=c.sigma_m) for c in found.crossings
        ),
        advice=tuple(advice_of(found)),
    )


def deflection_of(service: Service, campaign: str, test: Test | None, hz: float, at: int) -> DeflectionView:
    """The operating deflection shape that the measured mobility shows.

    Raises:
        NotFoundError: no such campaign, no model of this test, or no measured mobility.
        DataError: a frequency outside the FRFs, or a point that was not driven.
    """
    from modallab.modification.deflection import operating_deflection
    from modallab.modification.freedoms import freedoms_of

    known = known_of_campaign(service, campaign, test)
    curves = next(c for c in curves_of_campaign(service, campaign).tests if c.test == known.model.test)
    if curves.measured is None or known.rig is None:
        raise NotFoundError(f"campaign {campaign} has no measured FRF of this test", remedy="name another test")
    points = curves.outputs, curves.output_points, curves.input_points
    variance = None if curves.sigma is None else curves.sigma**2
    frf = Frf(curves.frequency_hz, curves.measured, "mobility", *points, variance=variance)
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
