"""What a diagnosis is worth on a campaign that was made later: does the gap stay shut once it is in the simulation?"""

from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import NamedTuple

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.hold_out import MIXED
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.initial_gap import gap_before, gap_known, gap_unseen
from modallab.gap.report.shrinkage import BARE, closed_share
from modallab.gap.revisions.apply import with_diagnosis
from modallab.twin.effects import model_of


class RepeatedCampaign(NamedTuple):
    """A diagnosis compared with a later campaign.

    Attributes:
        closed: share of the reducible gap that it closes there; None where there was next to none.
        shut: whether that campaign has no gap to the simulation that carries the diagnosis.
    """

    closed: float | None
    shut: bool


def diagnose_later(later: Path, diagnosis: Diagnosis) -> RepeatedCampaign:
    """Hold a diagnosis that names effects against a later campaign on the same bench."""
    campaign = read_campaign(later)
    revised = replace(campaign, rig=with_diagnosis(campaign.rig, diagnosis, date.min))
    before, after = _gaps_before_and_after(campaign, revised, diagnosis)
    share = closed_share(before, after) if before**2 - 1 > BARE else None
    return RepeatedCampaign(share, diagnose(revised).verdict == "no_gap")


def _gaps_before_and_after(campaign: Campaign, revised: Campaign, diagnosis: Diagnosis) -> tuple[float, float]:
    """In noise units, on what a diagnosis measures its shrinkage on: records that its fits have not seen."""
    if any(model_of(f.effect).search is None for f in diagnosis.effects):
        # What no force predicts is in each record on its own.
        return gap_before(campaign), gap_known(revised)
    return gap_unseen(campaign, MIXED), gap_unseen(revised, MIXED)
