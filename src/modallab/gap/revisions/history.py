"""How a simulation came closer to its bench, revision by revision."""

from collections.abc import Sequence
from dataclasses import replace

from modallab.core.block import Campaign
from modallab.core.effect import Revision
from modallab.core.frozen import Frozen
from modallab.core.progress import count_progress
from modallab.core.rig import Rig
from modallab.gap.report.initial_gap import gap_outside_revisions
from modallab.gap.revisions.apply import rig_at_revision
from modallab.twin.effects import model_of


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
