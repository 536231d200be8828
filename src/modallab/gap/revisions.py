"""The next revision of a rig: its twin and its simulated bench carry what a diagnosis has found."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import date

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis, FoundEffect
from modallab.core.effect import Effect, OneChannel, Revision
from modallab.core.errors import DataError, RigError
from modallab.core.frozen import Frozen
from modallab.core.progress import count_progress
from modallab.core.rig import Rig
from modallab.gap.report.initial_gap import gap_outside_revisions
from modallab.twin.effects import model_of


def with_diagnosis(rig: Rig, diagnosis: Diagnosis, on: date, source: str = "") -> Rig:
    """The rig with one revision more: the effects of a diagnosis.

    Args:
        rig: the bench as it was believed when it was diagnosed.
        diagnosis: of a campaign on it.
        on: the day.
        source: the campaign that was diagnosed, in words.

    Raises:
        RigError: the diagnosis is of another rig, or its effects are in the rig already.
        DataError: the diagnosis names no effect, and describes none by what it behaves like.
    """
    if diagnosis.rig != rig.name:
        raise RigError(
            f"the diagnosis is of {diagnosis.rig!r}, the rig file of {rig.name!r}",
            remedy="name the rig file that the campaign was diagnosed with",
        )
    described = diagnosis.described
    named = tuple(_as_known_effects(found) for found in diagnosis.effects)
    effects = named if described is None else tuple(element.as_effect() for element in described.elements)
    if (diagnosis.verdict != "known" and described is None) or not effects:
        verdict = {
            "no_gap": "that there is no gap",
            "unknown": "that no known effect explains the gap, and no element describes it",
        }
        raise DataError(
            f"the diagnosis says {verdict.get(diagnosis.verdict, 'no effect')}",
            where=rig.name,
            remedy="apply no revision; make the test that the diagnosis suggests",
        )
    if any(effects == revision.effects for revision in rig.revisions):
        raise RigError(
            f"{' and '.join(e.effect for e in effects)} with these numbers is already in the rig",
            where=rig.name,
            remedy="apply a diagnosis that was made with this revision of the rig",
        )
    shrink = diagnosis.shrink if described is None else described.shrink
    revision = Revision(
        effects=effects, applied_on=on, before=shrink.before, after=shrink.after, closed=shrink.closed, source=source
    )
    return rig.model_copy(update={"revisions": (*rig.revisions, revision)})


def rig_at_revision(rig: Rig, number: int) -> Rig:
    """The rig as it was after so many revisions; 0 is before any."""
    return rig.model_copy(update={"revisions": rig.revisions[:number]})


def _as_known_effects(found: FoundEffect) -> Effect:
    effect = found.as_effect()
    if not isinstance(effect.place, OneChannel):
        return effect
    # A level in V is of the records that were diagnosed; the share of the peak is of the bench.
    return effect.model_copy(update={"place": OneChannel(channel=effect.place.channel)})


class RevisionStep(Frozen):
    """One revision of a rig's simulation.

    Attributes:
        number: 0 is the rig file before any diagnosis was applied.
        effects: that came with it, in words.
        gap: of the simulation so revised, in noise units, as it was found on the records held out when the diagnosis
            was made; None before the first.
        measured: campaign -> the same on all records of that campaign.
    """

    number: int
    effects: str
    gap: float | None
    measured: dict[str, float]


def revision_history(rig: Rig, campaigns: Sequence[Campaign] = ()) -> list[RevisionStep]:
    """The revisions of a rig, each with its gap; on campaigns all are measured alike, nuisances fitted.

    Raises:
        DataError: a campaign holds nothing to compare.
        RigError: the rig has no beam.
    """
    steps = [("as first believed", rig.revisions[0].before if rig.revisions else None)]
    steps += [(_revision_in_words(revision), revision.after) for revision in rig.revisions]
    measured = _measure_revisions(rig, campaigns)
    return [
        RevisionStep(
            number=number, effects=said, gap=gap, measured={name: gaps[number] for name, gaps in measured.items()}
        )
        for number, (said, gap) in enumerate(steps)
    ]


def _revision_in_words(revision: Revision) -> str:
    return " and ".join(model_of(e.effect).spoken for e in revision.effects)


def _measure_revisions(rig: Rig, campaigns: Sequence[Campaign]) -> dict[str, list[float]]:
    numbers = range(len(rig.revisions) + 1)
    pairs = [(campaign, number) for campaign in campaigns for number in numbers]
    gaps = [
        gap_outside_revisions(replace(campaign, rig=rig_at_revision(rig, number)))
        for campaign, number in count_progress(pairs, len(pairs), "revisions")
    ]
    per = len(numbers)
    return {c.source or f"campaign {k + 1}": gaps[k * per : (k + 1) * per] for k, c in enumerate(campaigns)}
