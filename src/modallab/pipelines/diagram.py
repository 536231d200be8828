"""The stabilisation diagram of an identified test."""

from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.frf import Frf
from modallab.core.units import BROADBAND
from modallab.frf.broadband import blocks_of_one_level, broadband_frf
from modallab.frf.estimate import group_by_point
from modallab.identification.estimate import estimate_poles
from modallab.identification.estimator import USUAL, find_estimator
from modallab.identification.impact import start_frf
from modallab.identification.selection.diagram import StabilisationData, stabilisation_diagram
from modallab.identification.sine import START, highest_order, stepped_start
from modallab.identification.start.stabilisation import StabilityLimits
from modallab.pipelines.identify import IdentifiedTest, usable_blocks


def diagram_of(campaign: Campaign, item: IdentifiedTest, frf: Frf | None = None) -> StabilisationData | str:
    """The diagram, or why there is none.

    Args:
        campaign: the recordings.
        item: a test's model; one of an estimator without orders is drawn beside the poles of the usual one.
        frf: the FRF, if it came as such.
    """
    try:
        seen, order, tolerance = _diagram_of_item(campaign, item, frf)
        # What has no orders is drawn beside the poles of one that has.
        method = item.model.method if find_estimator(item.model.method).order is not None else USUAL
        return stabilisation_diagram(seen, estimate_poles(seen, method, order, tolerance).orders, tolerance)
    except ModallabError as error:
        return error.what


def _diagram_of_item(
    campaign: Campaign, item: IdentifiedTest, frf: Frf | None
) -> tuple[Frf, int | None, StabilityLimits | None]:
    if frf is not None:
        return frf, None, None
    if item.source == "impact":
        signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
        return start_frf(group_by_point(signals), rig, item.model.band_hz), None, None
    if item.source in BROADBAND:
        signals, rig, _ = usable_blocks(campaign, campaign.of(item.source))
        return broadband_frf(blocks_of_one_level(signals), rig, item.model.band_hz), None, None
    signals, rig, _ = usable_blocks(campaign, campaign.of("sine"))
    seen = stepped_start(signals, rig, item.model.band_hz)
    return seen, highest_order(seen), START
