"""Engines that can be scored: functions from a campaign, and of a structure its reference, to a diagnosis."""

from corpus.made import ModalTest, Reference
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.gap.diagnosis import diagnose
from modallab.gap.modal.diagnosis import diagnose_by_model


def today(campaign: Campaign | ModalTest, reference: Reference | None = None) -> Diagnosis | ModalDiagnosis:
    """What `modallab gap diagnose` runs."""
    if isinstance(campaign, ModalTest):
        assert reference is not None
        return diagnose_by_model(reference.model, campaign.model, campaign.rig, reference.mesh)
    return diagnose(campaign)
