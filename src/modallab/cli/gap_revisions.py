"""`modallab gap apply` and `modallab gap history`: a diagnosis put to work, and what that has brought."""

import argparse
from datetime import date

from pydantic import TypeAdapter
from rich.console import Console
from rich.table import Table

from modallab.cli.console import console_of, write_json
from modallab.cli.gap import read_diagnosis
from modallab.core.digits import three_digits
from modallab.core.progress import report_progress_to
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig, write_rig
from modallab.gap.revisions import RevisionStep, revision_history, with_diagnosis
from modallab.reporting.revisions_report import write_revisions_report

_STEPS: TypeAdapter[list[RevisionStep]] = TypeAdapter(list[RevisionStep])


def run(arguments: argparse.Namespace) -> int:
    """Apply, or show the history."""
    return _apply(arguments) if arguments.action == "apply" else _history(arguments)


def _apply(arguments: argparse.Namespace) -> int:
    diagnosis = read_diagnosis(arguments.diagnosis)
    source = arguments.source or arguments.diagnosis.name
    rig = with_diagnosis(read_rig(arguments.rig), diagnosis, date.today(), source)  # noqa: DTZ011
    write_rig(rig, arguments.out)
    names = " and ".join(e.effect.replace("_", " ") for e in rig.revisions[-1].effects)
    Console().print(f"revision {len(rig.revisions)}, with {names}: {arguments.out}", markup=False, soft_wrap=True)
    return 0


def _history(arguments: argparse.Namespace) -> int:
    rig = read_rig(arguments.rig)
    campaigns = [read_campaign(path, rig) for path in arguments.on or ()]
    console = console_of(arguments)
    with console.status("reading the records") as status, report_progress_to(lambda _, words: status.update(words)):
        steps = revision_history(rig, campaigns)
    console.print(_table(steps))
    if arguments.json is not None:
        write_json(arguments.json, _STEPS.dump_python(steps, mode="json"))
    if arguments.report is not None:
        write_revisions_report(arguments.report, rig, steps)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def _table(steps: list[RevisionStep]) -> Table:
    table = Table("revision", "with", "gap when applied", *steps[0].measured)
    for step in steps:
        gap = "" if step.gap is None else three_digits(step.gap)
        table.add_row(str(step.number), step.effects, gap, *(f"{v:.3g}" for v in step.measured.values()))
    return table
