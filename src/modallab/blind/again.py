"""What a diagnosis is worth on a campaign that was made later: does the gap stay shut once it is in the simulation?"""

from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import NamedTuple

from modallab.core.diagnosis import Diagnosis
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.initial_gap import gap_before, gap_known
from modallab.gap.report.shrinkage import BARE, closed
from modallab.gap.revisions.apply import with_diagnosis


class Again(NamedTuple):
    """A diagnosis compared with a later campaign.

    Attributes:
        closed: share of the reducible gap that it closes there; None where there was next to none.
        shut: whether that campaign has no gap to the simulation that carries the diagnosis.
    """

    closed: float | None
    shut: bool


def again(later: Path, diagnosis: Diagnosis) -> Again:
    """Hold a diagnosis that names effects against a later campaign on the same bench."""
    campaign = read_campaign(later)
    revised = replace(campaign, rig=with_diagnosis(campaign.rig, diagnosis, date.min))
    before = gap_before(campaign)
    share = closed(before, gap_known(revised)) if before**2 - 1 > BARE else None
    return Again(share, diagnose(revised).verdict == "no_gap")
