"""A model that a command names, ready for use."""

from pathlib import Path

from modallab.core.errors import DataError
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.options import IdentificationOptions
from modallab.modification.freedoms import with_points
from modallab.modification.known import KnownStructure
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models
from modallab.reporting.waiting_line import waiting_line


def prepare_model(
    path: Path, rig: Rig | None, test: Test | None, *, progress: bool
) -> tuple[KnownStructure, Verification | None]:
    """A model ready for use, and what it was compared with where there is anything.

    Args:
        path: models, or a campaign to identify.
        rig: instead of that inside or beside it.
        test: whose model; None for the first.
        progress: whether to show that it is identified.

    Raises:
        DataError: there is no model of the test, or nothing to read.
    """
    if path.suffix == ".json":
        return KnownStructure(_choose_model(read_models(path), test), rig or _rig_beside(path)), None
    campaign = read_campaign(path, rig)
    # The others take as long, and nobody asked for them; hits are the first.
    asked = test or "impact"
    only = asked if campaign.of(asked) else None
    with waiting_line("identifying", progress=progress):
        result = identify_campaign(campaign, IdentificationOptions(), only)
    model = _choose_model([item.model for item in result.identified], test)
    verification = next(item.verification for item in result.identified if item.model is model)
    return KnownStructure(with_points(model, campaign.rig), campaign.rig), verification


def _rig_beside(path: Path) -> Rig | None:
    near = path.with_name("rig.yaml")
    return read_rig(near) if near.exists() else None


def _choose_model(models: tuple[ModalModel, ...] | list[ModalModel], test: str | None) -> ModalModel:
    fitting = [m for m in models if test in (None, m.test)]
    if not fitting:
        there = ", ".join(str(m.test) for m in models) or "none"
        raise DataError(f"there is no model of {'a' if test is None else test} test", remedy=f"there are: {there}")
    return fitting[0]
