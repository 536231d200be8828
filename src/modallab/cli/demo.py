"""`modallab demo`: both tests on the simulated bench, from the first hit to the report."""

import argparse
from importlib.resources import files
from pathlib import Path
from urllib.parse import quote

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from modallab.cli.identify import print_remarks, result_table
from modallab.core import events
from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import parse_rig, write_rig
from modallab.identification.options import Options
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import write_models
from modallab.pipelines.report import report_content
from modallab.reporting.report import write_report
from modallab.service.campaigns.demo_plan import demo_plans
from modallab.service.campaigns.plain_session import record_campaign
from modallab.storage import Store
from modallab.storage.campaigns import rejected_blocks


def run(arguments: argparse.Namespace) -> int:
    """Run both tests, identify, verify, and leave everything in one folder."""
    folder: Path = arguments.out
    folder.mkdir(parents=True, exist_ok=True)
    rig = demo_rig()
    console = Console()
    effects = "".join(f"&effect={quote(effect, safe=',=')}" for effect in arguments.effect or ())
    url = f"sim://cantilever?seed={arguments.seed}{effects}"
    console.print(f"bench {url}: {rig.name}, both tests", markup=False)
    campaign = _record(console, url, rig, folder)
    console.print("identifying ...")
    result = identify_campaign(campaign, Options())
    write_rig(rig, folder / "rig.yaml")
    write_campaign(campaign, folder / "campaign.h5")
    write_models(folder / "models.json", campaign, result)
    content = report_content(campaign, result, f"Modal test of {rig.name}", _rejected(folder, campaign))
    write_report(folder / "report.html", content)
    console.print(result_table(campaign, result))
    print_remarks(console, result)
    console.print("\nwritten:")
    for name in ("report.html", "campaign.h5", "models.json", "rig.yaml"):
        console.print(f"  {folder / name}", markup=False, highlight=False)
    return 0


def demo_rig() -> Rig:
    """The paper's link as a rig."""
    resource = files("modallab.service").joinpath("link_rig.yaml")
    return parse_rig(resource.read_text(encoding="utf-8"), "the demo's rig")


def _record(console: Console, url: str, rig: Rig, folder: Path) -> Campaign:
    bar = Progress(
        TextColumn("{task.description:<28}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), console=console
    )
    with bar:
        tasks = {}

        def notify(event: events.Event) -> None:
            if isinstance(event, events.Progress):
                if event.run not in tasks:
                    tasks[event.run] = bar.add_task(event.what, total=event.total)
                bar.update(tasks[event.run], completed=event.done, description=event.what)
            elif isinstance(event, events.HitRejected):
                console.print(f"  hit at point {event.point} rejected: {event.reason}", markup=False)

        return record_campaign(url, rig, demo_plans(), folder / "data", notify)


def _rejected(folder: Path, campaign: Campaign) -> list[tuple[Block, str]]:
    with Store(folder / "data") as store:
        return [pair for run_id in campaign.provenance["runs"].split() for pair in rejected_blocks(store, run_id)]
