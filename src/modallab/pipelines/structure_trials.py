"""Semi-real trials on anybody's campaign: its FRFs as they were measured, with known effects put into them."""

from pathlib import Path

from modallab.blind.measured.draw import MeasuredRequest
from modallab.blind.measured.run import run_trials_on
from modallab.blind.measured.score import MeasuredOutcome
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.identification.frf_model import frf_in_band
from modallab.identification.impact import default_band
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign, usable_blocks


def trials_on(campaign: Campaign, folder: Path, request: MeasuredRequest) -> MeasuredOutcome:
    """Semi-real trials on the first FRFs that a campaign holds or gives.

    Args:
        campaign: of any structure, with a force.
        folder: for the sealed truths and the answers; empty.
        request: which trials.

    Raises:
        DataError: it gives no FRFs, or no force was measured.
        IdentificationError: the FRFs hold no mode, or fewer than eight lines in the band.
    """
    frf = measured_frf(campaign)
    if request.band_hz is not None:
        frf = frf_in_band(frf, request.band_hz)
    return run_trials_on(frf, campaign.rig, folder, request, Path(campaign.source).name)


def measured_frf(campaign: Campaign) -> Frf:
    """FRFs of a campaign: those it came with, of its hits, or of its drive.

    Raises:
        DataError: it gives none.
    """
    if campaign.frfs:
        return campaign.frfs[0]
    if campaign.rig.force is None:
        raise DataError(
            "no force was measured, and so there are no FRFs",
            where=campaign.source,
            remedy="name a campaign with a force channel",
        )
    if campaign.of("impact"):
        signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
        groups = group_by_point(signals)
        return impact_frf(groups, rig, default_band(groups))
    verified = identify_campaign(campaign, IdentificationOptions()).identified[0].verification
    if verified is None:
        raise DataError("gives no FRFs", where=campaign.source, remedy="name a campaign of hits, sines or a drive")
    return verified.measured
