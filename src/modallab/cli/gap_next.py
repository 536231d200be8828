"""`modallab gap next`: the experiment that separates what a diagnosis has left standing, and what it brings."""

import argparse

from rich.console import Console
from rich.table import Table

from modallab.cli.console import ProgressDisplay, console_of, write_json
from modallab.cli.gap import read_diagnosis
from modallab.cli.options import require_option
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.digits import percent_text, probability_text
from modallab.core.errors import PlanError, RigError
from modallab.core.hold_out import SPREAD
from modallab.core.progress import report_progress_to
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.gap.design.experiments import DECIDES, Experiment, continue_campaign, next_experiments
from modallab.gap.design.explanations import remaining_explanations
from modallab.gap.diagnosis import diagnose
from modallab.gap.words.verdicts import verdict_sentence
from modallab.service.campaigns.local_session import record_campaign

SHOWN = 6


def run(arguments: argparse.Namespace) -> int:
    """Rank experiments; if asked, run the best on the bench and go on with its records."""
    if not arguments.run_it:
        require_option("--run", bench=arguments.bench, out=arguments.out, json=arguments.json)
    campaign = read_campaign(arguments.campaign, None if arguments.rig is None else read_rig(arguments.rig))
    diagnosis = read_diagnosis(arguments.diagnosis)
    console = console_of(arguments)
    with console.status("experiments") as status, report_progress_to(lambda _, words: status.update(words)):
        found = next_experiments(campaign, diagnosis)
    console.print(_table(found))
    if not found:
        raise PlanError("no experiment is possible on this rig", remedy="give the rig more points, or a shaker point")
    if found[0].expected < DECIDES:
        raise PlanError(
            "no experiment on this rig decides: even after the best one the right explanation has an expected "
            "probability"
            f" of only {found[0].expected:.2f}",
            where=campaign.rig.name,
            remedy=diagnosis.next_experiment or "add a sensor where the explanations differ",
        )
    console.print(_experiment_in_words(found[0]), markup=False)
    return _go_on(console, campaign, diagnosis, found[0], arguments) if arguments.run_it else 0


def _go_on(
    console: Console, campaign: Campaign, before: Diagnosis, best: Experiment, arguments: argparse.Namespace
) -> int:
    url = arguments.bench or campaign.rig.bench
    if not url:
        raise RigError("names no bench", where=campaign.rig.name, remedy="give --bench ADDRESS, or a field bench")
    with ProgressDisplay(console) as display:
        later = record_campaign(url, campaign.rig, best.plans, arguments.data, display.notify)
    whole = continue_campaign(campaign, later)
    if arguments.out is not None:
        write_campaign(whole, arguments.out)
    with console.status("reading the records") as status, report_progress_to(lambda _, words: status.update(words)):
        diagnosis = diagnose(whole, SPREAD, known=remaining_explanations(before))
    console.print(verdict_sentence(diagnosis, [c.name for c in whole.rig.channels]), markup=False)
    if arguments.json is not None:
        write_json(arguments.json, diagnosis.model_dump(mode="json"))
    return 0


def _experiment_in_words(best: Experiment) -> str:
    return (
        f"{best.says} Expected: the right explanation gets a probability of {probability_text(best.expected)};"
        f" {_duration_in_words(best.seconds)} at the bench."
    )


def _duration_in_words(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600 else f"{seconds / 60:.0f} min"


def _table(found: list[Experiment]) -> Table:
    now = f"{found[0].now:.2f}" if found else "-"
    table = Table(
        "experiment",
        "at the bench",
        "expected probability of the right explanation",
        "probability that only this one is left",
        title=f"likeliest explanation so far: {now}",
    )
    for e in found[:SHOWN]:
        table.add_row(e.name, _duration_in_words(e.seconds), probability_text(e.expected), percent_text(e.alone))
    return table
