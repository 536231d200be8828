"""Changes of a structure, by a campaign's newest model: the modes with them, and which a wanted property needs."""

from math import isfinite
from typing import TYPE_CHECKING, Annotated

from fastapi import Body

from modallab.core.documents.model_change import (
    AbsorberRequest,
    ChangeNew,
    CouplingRequest,
    ElementRequest,
    FrfRequest,
    MobilityView,
    ModificationRequest,
    ModifiedView,
)
from modallab.core.documents.model_targets import (
    BestAbsorberRequest,
    BestAbsorberView,
    ChangeForFreeBandRequest,
    ChangeForFreeBandView,
    ChangeForFrequencyRequest,
    ChangeForFrequencyView,
    ChangesForFreeBandView,
    ChangesForFrequencyView,
)
from modallab.service.api.access import role_needed
from modallab.service.api.problems import documented_responses
from modallab.service.api.request_context import ServiceOf
from modallab.service.api.router import make_router
from modallab.service.context import Service
from modallab.service.jobs.results import known_of_campaign, model_of_campaign

if TYPE_CHECKING:
    from modallab.modification.attachments import AttachedPart
    from modallab.modification.known import KnownStructure

router = make_router("model-use")


@router.post(
    "/campaigns/{campaign}/model/modifications",
    responses=documented_responses(404),
    openapi_extra=role_needed("observer"),
)
def modify_model(campaign: str, new: Annotated[ModificationRequest, Body()], service: ServiceOf) -> ModifiedView:
    """Predict the modes after changes of the structure; nothing is stored."""
    from modallab.modification.mesh import motion_of
    from modallab.reporting.modification_table import check_predictions, notes_of

    known = known_of_campaign(service, campaign, new.test)
    changes = [_addition(service, change) for change in new.changes]
    changed = known.with_changes(changes)
    after = changed.modes
    measured = None if new.check is None else model_of_campaign(service, new.check, new.test).model
    return ModifiedView.of_fields(
        after,
        test=known.model.test,
        changes=tuple(change.description for change in changes),
        like=tuple(int(n) + 1 for n in after.like),
        conditioning=changed.conditioning,
        notes=tuple(notes_of(changed)),
        before_hz=known.model.frequency_hz,
        frf=None if new.frf is None else _mobility(known, changed, new.frf),
        checked=() if measured is None else tuple(check_predictions(after, measured)),
        motion=None if known.rig is None else motion_of(known.structure, known.rig, after.psi),
    )


def _mobility(known: "KnownStructure", changed: "KnownStructure", pair: FrfRequest) -> MobilityView:
    from modallab.modification.frfs import lines_with_peaks

    f = lines_with_peaks(known.model.band_hz, pair.lines, known.structure.poles, changed.poles)
    before, after = (one.frf(f, [pair.of], [pair.at], sigma=False).values[0, 0] for one in (known, changed))
    return MobilityView(frequency_hz=f, before=before, after=after)


def _addition(service: Service, new: ChangeNew) -> "AttachedPart":
    from modallab.modification.attachments import Element, RigidLink, TunedAbsorber
    from modallab.modification.coupled import CouplingToStructure

    if isinstance(new, ElementRequest):
        return Element(new.at, new.to, new.mass_kg, new.spring_n_per_m, new.damper_n_s_per_m)
    if isinstance(new, AbsorberRequest):
        return TunedAbsorber(new.at, new.mass_kg, new.frequency_hz, new.damping_ratio)
    if isinstance(new, CouplingRequest):
        other = known_of_campaign(service, new.campaign, None)
        sign = -1 if new.remove else 1
        return CouplingToStructure(other.structure, new.pairs, new.joint_n_per_m, sign, samples=other.samples)
    return RigidLink(new.at, new.to)


@router.post(
    "/campaigns/{campaign}/model/tunings", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def tune_model(
    campaign: str, new: Annotated[ChangeForFrequencyRequest, Body()], service: ServiceOf
) -> ChangesForFrequencyView:
    """Find the mass or spring that moves a mode to a frequency, at each point; nothing is stored."""
    from modallab.modification.inverse import changes_for_frequency

    known = known_of_campaign(service, campaign, new.test)
    answers = changes_for_frequency(known, new.mode, new.to_hz, new.by, new.at or known.sensors)
    return ChangesForFrequencyView(
        test=known.model.test,
        tunings=tuple(
            ChangeForFrequencyView(
                at=a.at[0] if isinstance(a.at, tuple) else a.at,
                size=a.size if a.feasible else None,
                sigma=a.sigma if a.feasible else None,
                hz_sigma=a.hz_sigma if a.feasible else None,
                lowest_hz=a.lowest_hz,
                highest_hz=a.highest_hz,
            )
            for a in answers
        ),
    )


@router.post(
    "/campaigns/{campaign}/model/free-bands", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def free_band(
    campaign: str, new: Annotated[ChangeForFreeBandRequest, Body()], service: ServiceOf
) -> ChangesForFreeBandView:
    """Find the mass or spring that leaves no mode in a band, at each point; nothing is stored."""
    from modallab.modification.inverse import changes_for_free_band

    known = known_of_campaign(service, campaign, new.test)
    answers = tuple(
        ChangeForFreeBandView(
            at=a.at[0] if isinstance(a.at, tuple) else a.at,
            size=a.size if a.feasible else None,
            sigma=a.sigma if a.feasible else None,
            up_to=a.up_to if isfinite(a.up_to) else None,
            stays=a.stays or None,
            stays_hz=a.stays_hz if a.stays else None,
        )
        for a in changes_for_free_band(known, (new.low_hz, new.high_hz), new.by, new.at or known.sensors)
    )
    return ChangesForFreeBandView(test=known.model.test, answers=answers)


@router.post(
    "/campaigns/{campaign}/model/absorbers", responses=documented_responses(404), openapi_extra=role_needed("observer")
)
def find_absorber(campaign: str, new: Annotated[BestAbsorberRequest, Body()], service: ServiceOf) -> BestAbsorberView:
    """Find the absorber of a mass that makes the peak of a mode smallest; nothing is stored."""
    from modallab.modification.inverse import best_absorber

    known = known_of_campaign(service, campaign, new.test)
    found = best_absorber(known, new.mode, new.at, new.mass_kg)
    return BestAbsorberView(
        test=known.model.test,
        at=new.at,
        mass_kg=found.absorber.mass,
        frequency_hz=found.absorber.frequency_hz,
        damping_ratio=found.absorber.damping_ratio,
        mass_ratio=found.mass_ratio,
        peak_before=found.before,
        peak_before_sigma=found.before_sigma,
        peak_after=found.after,
        peak_after_sigma=found.after_sigma,
    )
