"""The stabilisation diagram of an identified test."""

from modallab.core.block import Campaign
from modallab.core.errors import ModallabError
from modallab.core.frf import Frf
from modallab.frf.estimate import group_by_point
from modallab.identification.estimators.registry import estimate_poles
from modallab.identification.estimators.stabilisation import Tolerance
from modallab.identification.impact import start_frf
from modallab.identification.selection.diagram import Diagram, stabilisation_diagram
from modallab.identification.sine import START, highest_order, stepped_start
from modallab.pipelines.identify import Identified, usable


def diagram_of(campaign: Campaign, item: Identified, frf: Frf | None = None) -> Diagram | str:
    """The diagram, or why there is none.

    Args:
        campaign: the recordings.
        item: a test's model; one of peaks is drawn beside the poles of pLSCF.
        frf: the FRF, if it came as such.
    """
    try:
        seen, order, tolerance = _seen(campaign, item, frf)
        ordered = "era" if item.model.method == "era" else "plscf"
        return stabilisation_diagram(seen, estimate_poles(seen, ordered, order, tolerance).orders, tolerance)
    except ModallabError as error:
        return error.what


def _seen(campaign: Campaign, item: Identified, frf: Frf | None) -> tuple[Frf, int | None, Tolerance | None]:
    if frf is not None:
        return frf, None, None
    if item.source == "impact":
        signals, _ = usable(campaign, campaign.of("impact"))
        return start_frf(group_by_point(signals), campaign.rig, item.model.band_hz), None, None
    signals, _ = usable(campaign, campaign.of("sine"))
    seen = stepped_start(signals, campaign.rig, item.model.band_hz)
    return seen, highest_order(seen), START
