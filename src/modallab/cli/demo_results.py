"""What `modallab demo` makes of its recordings: models, files, the report, and what is printed."""

import argparse
from pathlib import Path

from modallab.cli.background_result import BackgroundResult
from modallab.cli.console import console_of
from modallab.cli.identify import print_remarks, result_table
from modallab.core.block import Block, Campaign
from modallab.core.units import Test
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import write_rig
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import IdentifiedTest, identify_campaign
from modallab.pipelines.model_file import write_models
from modallab.pipelines.report import report_content
from modallab.reporting.report import write_report
from modallab.reporting.waiting_line import waiting_line
from modallab.storage import Store
from modallab.storage.campaigns import rejected_blocks


def identify_test(campaign: Campaign, test: Test) -> IdentifiedTest:
    """One test of a campaign. Raises as `identify_campaign`."""
    return identify_campaign(campaign, IdentificationOptions(), test).identified[0]


def write_demo_results(
    arguments: argparse.Namespace, campaign: Campaign, struck: BackgroundResult[IdentifiedTest]
) -> None:
    """Identify what is left, write everything into the folder, and print the table.

    Args:
        arguments: of the command.
        campaign: both tests.
        struck: the impact test, already being identified.

    Raises:
        IdentificationError: no test holds a mode.
        StorageError: a file cannot be written.
    """
    folder: Path = arguments.out
    console = console_of(arguments)
    console.print("identifying ...")
    with waiting_line("identifying", progress=not arguments.hush):
        result = identify_campaign(campaign, IdentificationOptions(), ahead={"impact": struck.result})
    write_rig(campaign.rig, folder / "rig.yaml")
    write_campaign(campaign, folder / "campaign.h5")
    write_models(folder / "models.json", campaign, result)
    title = f"Modal test of {campaign.rig.name}"
    write_report(folder / "report.html", report_content(campaign, result, title, _write_rejected(folder, campaign)))
    console.print(result_table(campaign, result))
    print_remarks(console, result)
    console.print("\nwritten:")
    for name in ("report.html", "campaign.h5", "models.json", "rig.yaml"):
        console.print(f"  {folder / name}", markup=False, highlight=False)


def _write_rejected(folder: Path, campaign: Campaign) -> list[tuple[Block, str]]:
    with Store(folder / "data") as store:
        return [pair for run_id in campaign.provenance["runs"].split() for pair in rejected_blocks(store, run_id)]
