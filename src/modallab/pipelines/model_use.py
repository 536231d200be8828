"""A modal model of a campaign made ready for use."""

from modallab.core.block import Campaign
from modallab.core.model import ModalModel
from modallab.modification.freedoms import with_points
from modallab.modification.known import KnownStructure


def known_of(campaign: Campaign, model: ModalModel) -> KnownStructure:
    """The structure that a model describes, with the tolerances of its rig.

    Raises:
        DataError: an output or input has no point.
    """
    return KnownStructure(with_points(model, campaign.rig), campaign.rig)
