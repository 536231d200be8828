"""`modallab export`: a campaign in a format of others."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from modallab.cli.backup import require_data_folder
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import FrfEstimator
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.exporter import write_export
from modallab.formats.rig.rig_file import read_rig
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.identification.impact import default_band
from modallab.pipelines.model_file import read_models
from modallab.signals.signals import to_signals_of
from modallab.storage import Store, campaign_of


def run(arguments: argparse.Namespace) -> int:
    """Export, and say what had no place in the format."""
    rig = None if arguments.rig is None else read_rig(arguments.rig)
    campaign = _campaign(arguments.source, arguments.run or (), rig)
    if arguments.frf is not None:
        campaign = _with_frfs(campaign, arguments.frf)
    models: Sequence[ModalModel] = () if arguments.models is None else read_models(arguments.models)
    console = Console()
    for note in write_export(campaign, arguments.out, arguments.format, models):
        console.print(f"note: {note}", markup=False, highlight=False)
    held = f"{len(campaign.blocks)} records, {len(campaign.frfs)} FRF matrices"
    console.print(f"{arguments.format}: {held}: {arguments.out}", markup=False, highlight=False, soft_wrap=True)
    return 0


def _campaign(source: Path, runs: Sequence[str], rig: Rig | None) -> Campaign:
    if not runs:
        return read_campaign(source, rig)
    require_data_folder(source)
    with Store(source) as store:
        campaign = campaign_of(store, runs)
    return campaign if rig is None else replace(campaign, rig=rig)


def _with_frfs(campaign: Campaign, estimator: FrfEstimator) -> Campaign:
    if not campaign.of("impact"):
        raise DataError("there are no hits, and so no FRFs", where=campaign.source, remedy="leave --frf out")
    groups = group_by_point(to_signals_of(campaign.of("impact"), campaign.rig))
    frf = impact_frf(groups, campaign.rig, default_band(groups), estimator=estimator)
    return replace(campaign, frfs=(*campaign.frfs, frf))
