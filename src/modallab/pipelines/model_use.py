"""A modal model of a campaign made ready for use."""

from collections import Counter

from modallab.core.block import Campaign
from modallab.core.model import ModalModel
from modallab.modification.freedoms import with_points
from modallab.modification.known import KnownStructure


def known_of(campaign: Campaign, model: ModalModel) -> KnownStructure:
    """The structure that a model describes, with the tolerances of its rig and its number of hits.

    Raises:
        DataError: an output or input has no point.
    """
    model = with_points(model, campaign.rig)
    hits = Counter(block.drive_point for block in campaign.of("impact")) if model.test == "impact" else Counter()
    return KnownStructure(model, campaign.rig, [max(1, hits[point]) for point in model.input_points])
