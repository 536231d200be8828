"""From records of any structure, and its modal model from before, to what has changed."""

from pathlib import Path

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.fem.fem_file import is_fem, read_fem
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.options import Options
from modallab.pipelines.finite_elements import model_of_elements
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models


def diagnose_structure(campaign: Campaign, reference: ModalModel) -> ModalDiagnosis:
    """What differs between a modal model and the structure of a campaign, beyond the tolerances of its rig.

    Raises:
        DataError: no force was measured, or the two have nothing in common.
        IdentificationError: the campaign holds no mode.
    """
    return diagnose_by_model(reference, model_to_compare(campaign), campaign.rig)


def diagnose_against(campaign: Campaign, path: Path) -> ModalDiagnosis:
    """The same against the reference in a file: models, a campaign from before, or a finite-element model.

    Raises:
        DataError: no force was measured, or the two have nothing in common.
        FormatError: the file can be read as none of these.
        IdentificationError: a campaign holds no mode.
    """
    bench = model_to_compare(campaign)
    return diagnose_by_model(read_reference(path, campaign.rig, bench), bench, campaign.rig)


def model_to_compare(campaign: Campaign) -> ModalModel:
    """The campaign's first modal model: of hits where there are any, else of the next test.

    Raises:
        DataError: no force was measured, so that the modal constants are not known.
        IdentificationError: there is no mode.
    """
    if campaign.rig.force is None:
        raise DataError(
            "no force was measured: modal constants are not known, and nothing can be compared with them",
            where=campaign.source,
            remedy="compare campaigns with a force channel",
        )
    return identify_campaign(campaign, Options()).identified[0].model


def read_reference(path: Path, rig: Rig, bench: ModalModel) -> ModalModel:
    """The reference of a file of models, of a finite-element model, or of a campaign, which is identified.

    Args:
        path: of it.
        rig: whose points and channels it is taken at.
        bench: what is compared with it: in its band, and driven where it was, a finite-element model is taken.

    Raises:
        DataError: it holds no model, or none that fits the rig.
        FormatError: it can be read as none of these.
        IdentificationError: the campaign holds no mode.
    """
    if path.suffix == ".json":
        models = read_models(path)
        if not models:
            raise DataError("holds no model", where=str(path), remedy="write one with modallab identify --json")
        return models[0]
    if is_fem(path):
        driven = tuple(p for p in dict.fromkeys(bench.input_points) if p is not None)
        return model_of_elements(read_fem(path), rig, bench.band_hz, driven)
    return model_to_compare(read_campaign(path, rig))
