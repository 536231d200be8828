"""The newest model of a campaign put to use. What it needs takes seconds to import, so it is imported when used."""

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from modallab.core.documents.model_change import (
    AbsorberNew,
    ChangeNew,
    CheckedMode,
    CouplingNew,
    ElementNew,
    MobilityView,
    ModificationNew,
    ModifiedView,
    PairNew,
)
from modallab.core.documents.model_use import (
    CrossingView,
    DeflectionView,
    NodesView,
    ParticipationView,
    PredictedFrf,
    ResponseNew,
    ResponseView,
)
from modallab.core.documents.models import TestModel
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.units import Quantity, Test
from modallab.service.context import Service
from modallab.service.errors import NotFoundError
from modallab.service.jobs.results import curves_of_campaign, models_of_campaign

if TYPE_CHECKING:
    from modallab.modification.attachments import Addition
    from modallab.modification.known import Known

KEPT = 8
"""Models that stay ready for use: their samples take longer than what is asked of them."""
_READY: dict[tuple[str, Test | None, tuple[str, ...]], "Known"] = {}
LOWEST = 1e-3
"""Of the upper edge of a band that begins at 0 Hz: the first line of FRFs."""


def participation_of(
    service: Service, campaign: str, test: Test | None, at: int, of: int, quantity: Quantity, band_hz: tuple[float, ...]
) -> ParticipationView:
    """Which modes make the response at a point.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a band outside the model's, a point that it does not know, or no driving point.
    """
    from modallab.modification.known import FRF_SAMPLES
    from modallab.modification.participation import participation

    known = known_of_campaign(service, campaign, test)
    band = (band_hz[0], band_hz[1]) if band_hz else None
    found = participation(known.structure, known.samples.first(FRF_SAMPLES), at, of, quantity, band)
    return ParticipationView(
        test=known.model.test,
        at=at,
        of=of,
        quantity=quantity,
        band_hz=found.band_hz or known.model.band_hz,
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
    frf = Frf(
        curves.frequency_hz, curves.measured, "mobility", curves.outputs, curves.output_points, curves.input_points
    )
    found = operating_deflection(frf, freedoms_of(known.model, known.rig)[0], hz, at)
    return DeflectionView(
        test=known.model.test,
        frequency_hz=found.frequency_hz,
        at=at,
        points=tuple(point for point, _ in found.freedoms),
        axes=tuple(axis for _, axis in found.freedoms),
        values=found.values.astype(np.complex128),
    )


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
    known = known_of_campaign(service, campaign, test)
    low, high = known.model.band_hz
    found = known.frf(np.linspace(max(low, LOWEST * high), high, lines), outputs, inputs, quantity)
    assert found.variance is not None
    return PredictedFrf(
        test=known.model.test,
        quantity=quantity,
        frequency_hz=found.frequency_hz,
        outputs=tuple(p or 0 for p in found.output_points),
        inputs=tuple(p or 0 for p in found.input_points),
        values=found.values,
        sigma=np.sqrt(found.variance),
    )


def modified(service: Service, campaign: str, new: ModificationNew) -> ModifiedView:
    """The modes after changes.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: a change that is none, a point that the model does not know, or no driving point.
    """
    from modallab.reporting.modified_table import checked, notes_of

    known = known_of_campaign(service, campaign, new.test)
    changes = [_addition(service, change) for change in new.changes]
    changed = known.with_changes(changes)
    after = changed.modes
    measured = None if new.check is None else _chosen(service, new.check, new.test).model
    return ModifiedView(
        test=known.model.test,
        changes=tuple(change.words for change in changes),
        frequency_hz=after.frequency_hz,
        frequency_sigma_hz=after.frequency_sigma_hz,
        damping_ratio=after.damping_ratio,
        damping_sigma=after.damping_sigma,
        like=tuple(int(n) + 1 for n in after.like),
        mac=after.mac,
        outside=after.outside,
        notes=tuple(notes_of(known.model, after)),
        before_hz=known.model.frequency_hz,
        frf=None if new.frf is None else _mobility(known, changed, new.frf),
        checked=()
        if measured is None
        else tuple(
            CheckedMode(
                mode=c.mode,
                predicted_hz=c.predicted_hz,
                predicted_sigma_hz=c.sigma_hz,
                measured_hz=c.measured_hz,
                inside=c.inside,
                words=c.words,
            )
            for c in checked(after, measured)
        ),
    )


def _mobility(known: "Known", changed: "Known", pair: PairNew) -> MobilityView:
    low, high = known.model.band_hz
    f = np.linspace(max(low, LOWEST * high), high, pair.lines)
    before, after = (one.frf(f, [pair.of], [pair.at], sigma=False).values[0, 0] for one in (known, changed))
    return MobilityView(frequency_hz=f, before=before, after=after)


def _addition(service: Service, new: ChangeNew) -> "Addition":
    from modallab.modification.attachments import Coupled, Element, RigidLink, TunedAbsorber

    if isinstance(new, ElementNew):
        return Element(new.at, new.to, new.mass_kg, new.spring_n_per_m, new.damper_n_s_per_m)
    if isinstance(new, AbsorberNew):
        return TunedAbsorber(new.at, new.mass_kg, new.frequency_hz, new.damping_ratio)
    if isinstance(new, CouplingNew):
        other = known_of_campaign(service, new.campaign, None).structure
        return Coupled(other, new.pairs, new.joint_n_per_m, -1 if new.remove else 1)
    return RigidLink(new.at, new.to)


def response_to(service: Service, campaign: str, new: ResponseNew) -> ResponseView:
    """The motion that forces give, from rest.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: forces that cannot be, a point that the model does not know, or no driving point.
    """
    known = known_of_campaign(service, campaign, new.test)
    if len(new.forces_n) != len(new.at) or len({len(force) for force in new.forces_n}) > 1:
        raise DataError(
            f"{len(new.forces_n)} forces at {len(new.at)} points",
            where="forces_n",
            remedy="give a row for each point, all of one length",
        )
    of = new.of or tuple(point for point, _ in known.structure.freedoms[: len(known.model.outputs)])
    motion = known.response(np.array(new.forces_n), new.step_s, new.at, of, new.quantity, new.between)
    return ResponseView(
        test=known.model.test,
        quantity=new.quantity,
        step_s=new.step_s,
        of=of,
        values=motion,
        peak=np.abs(motion).max(axis=1),
        rms=np.sqrt(np.mean(motion**2, axis=1)),
    )


def known_of_campaign(service: Service, campaign: str, test: Test | None) -> "Known":
    """The newest model of a test, ready for use; of the first test if none is named.

    Raises:
        NotFoundError: no such campaign, or no model of this test.
        DataError: no driving point, or a point that is not known.
    """
    from modallab.modification.known import Known

    found = _chosen(service, campaign, test)
    key = (found.job, found.model.test, found.runs)
    if key in _READY:
        return _READY[key]
    rows = [row.note for run in found.runs for row in service.store.catalogue.blocks(run)]
    hits = Counter(note.drive_point for note in rows if note.accepted and note.test == "impact")
    counted = [max(1, hits[point]) if found.model.test == "impact" else 1 for point in found.model.input_points]
    known = Known(found.model, service.store.catalogue.run(found.runs[0]).rig, counted)
    while len(_READY) >= KEPT:
        _READY.pop(next(iter(_READY)))
    return _READY.setdefault(key, known)


def _chosen(service: Service, campaign: str, test: Test | None) -> TestModel:
    there = models_of_campaign(service, campaign).models
    for one in there:
        if test in (None, one.model.test):
            return one
    raise NotFoundError(
        f"campaign {campaign} has no model of {'any' if test is None else 'the ' + test} test",
        where="test",
        remedy=f"there are: {', '.join(str(one.model.test) for one in there) or 'none'}",
    )
