"""`modallab gap next`: the experiment that separates what a diagnosis has left standing, and what it brings."""

import argparse

from rich.console import Console
from rich.table import Table

from modallab.cli.gap import read_diagnosis
from modallab.cli.options import only_with
from modallab.cli.progress import Display
from modallab.core.block import Campaign
from modallab.core.errors import PlanError, RigError
from modallab.core.progress import heard_by
from modallab.formats.atomic import replacing
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.gap.design.experiments import APART, Experiment, continued, next_experiments
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.summary import sentence
from modallab.service.campaigns.local_session import record_campaign

SHOWN = 6


def run(arguments: argparse.Namespace) -> int:
    """Rank experiments; if asked, run the best on the bench and go on with its records."""
    if not arguments.run_it:
        only_with("--run", bench=arguments.bench, out=arguments.out, json=arguments.json)
    campaign = read_campaign(arguments.campaign, None if arguments.rig is None else read_rig(arguments.rig))
    diagnosis = read_diagnosis(arguments.diagnosis)
    console = Console()
    with console.status("experiments") as status, heard_by(lambda _, words: status.update(words)):
        found = next_experiments(campaign, diagnosis)
    console.print(_table(found))
    if not found:
        raise PlanError("no experiment is possible on this rig", remedy="give the rig more points, or a shaker point")
    if found[0].after < APART:
        raise PlanError(
            f"no experiment on this rig decides: the best leaves {found[0].after:.2g} noise units between them",
            where=campaign.rig.name,
            remedy=diagnosis.next_experiment or "add a sensor where the explanations differ",
        )
    console.print(found[0].says, markup=False)
    return _go_on(console, campaign, found[0], arguments) if arguments.run_it else 0


def _go_on(console: Console, campaign: Campaign, best: Experiment, arguments: argparse.Namespace) -> int:
    url = arguments.bench or campaign.rig.bench
    if not url:
        raise RigError("names no bench", where=campaign.rig.name, remedy="give --bench ADDRESS, or a field bench")
    with Display(console) as display:
        later = record_campaign(url, campaign.rig, best.plans, arguments.data, display.notify)
    whole = continued(campaign, later)
    if arguments.out is not None:
        write_campaign(whole, arguments.out)
    with console.status("reading the records") as status, heard_by(lambda _, words: status.update(words)):
        diagnosis = diagnose(whole)
    console.print(sentence(diagnosis, [c.name for c in whole.rig.channels]), markup=False)
    if arguments.json is not None:
        with replacing(arguments.json) as draft:
            draft.write_text(diagnosis.model_dump_json(indent=1) + "\n", encoding="utf-8", newline="\n")
    return 0


def _table(found: list[Experiment]) -> Table:
    table = Table("experiment", "minutes", "apart before", "apart after", title="noise units between the explanations")
    for experiment in found[:SHOWN]:
        minutes = f"{experiment.seconds / 60:.0f}"
        table.add_row(experiment.name, minutes, f"{experiment.before:.3g}", f"{experiment.after:.3g}")
    return table
