"""`modallab gap`: diagnose a campaign, predict another, or say beforehand what a plan can distinguish."""

import argparse
from pathlib import Path
from typing import Any, cast

import h5py
import yaml
from pydantic import TypeAdapter, ValidationError
from rich.console import Console
from rich.table import Table

from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import FormatError, PlanError
from modallab.core.plan import Plan
from modallab.core.progress import heard_by
from modallab.core.versions import PREDICTION
from modallab.formats.atomic import replacing
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.gap.design.distinguishability import advice, distinguishability
from modallab.gap.design.prediction import predict, predicted_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.summary import in_percent, sentence
from modallab.reporting.gap_report import write_gap_report

_PLAN: TypeAdapter[Plan] = TypeAdapter(Plan)


def run(arguments: argparse.Namespace) -> int:
    """Run the chosen one of the three."""
    return {"diagnose": _diagnose, "predict": _predict, "distinguishability": _distinguishability}[arguments.action](
        arguments
    )


def _diagnose(arguments: argparse.Namespace) -> int:
    campaign = read_campaign(arguments.campaign, None if arguments.rig is None else read_rig(arguments.rig))
    console = Console()
    with console.status("reading the records") as status, heard_by(lambda _, words: status.update(words)):
        diagnosis = diagnose(campaign, arguments.hold_out)
    console.print(sentence(diagnosis), markup=False)
    calibrate = diagnosis.budget.calibrate if diagnosis.budget is not None else []
    next_one = f"Next: {diagnosis.next_experiment}"
    for line in (in_percent(diagnosis.gap), *diagnosis.where.why, *diagnosis.notes, *calibrate, next_one):
        console.print(f"  {line}", markup=False)
    if arguments.json is not None:
        with replacing(arguments.json) as draft:
            draft.write_text(diagnosis.model_dump_json(indent=1) + "\n", encoding="utf-8", newline="\n")
    if arguments.report is not None:
        write_gap_report(arguments.report, diagnosis, campaign)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def _predict(arguments: argparse.Namespace) -> int:
    diagnosis = read_diagnosis(arguments.diagnosis)
    read_campaign(arguments.campaign)
    other = read_campaign(arguments.on)
    records = predict(diagnosis, other)
    responses = other.rig.responses
    with replacing(arguments.out) as draft, h5py.File(draft, "w") as target:
        target.attrs["format_version"] = PREDICTION
        target.attrs["channels"] = [c.name for c in responses]
        target.attrs["units"] = [c.unit for c in responses]
        target.attrs["directions"] = [c.direction for c in responses]
        for name, values in records.items():
            target.create_dataset(name, data=values)
    Console().print(f"predicted {len(records)} records: {arguments.out}", markup=False)
    if arguments.as_campaign is not None:
        write_campaign(predicted_campaign(diagnosis, other), arguments.as_campaign)
        Console().print(f"as a campaign: {arguments.as_campaign}", markup=False)
    return 0


def read_diagnosis(path: Path) -> Diagnosis:
    """A diagnosis from its file.

    Raises:
        FormatError: it cannot be read, or is no diagnosis.
    """
    try:
        return Diagnosis.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}", where=str(path), remedy="name a diagnosis") from error
    except ValidationError as error:
        raise FormatError(
            f"is no diagnosis: {error.error_count()} fields are wrong, the first {error.errors()[0]['loc']}",
            where=str(path),
            remedy="write it with `modallab gap diagnose --json`",
        ) from error


def _distinguishability(arguments: argparse.Namespace) -> int:
    plans = read_plans(arguments.plan)
    found = distinguishability(read_rig(arguments.rig), plans)
    console = Console()
    pairs = found.alike()
    table = Table("effect", "and", "cosine where they are most alike")
    for first, second, cosine in pairs:
        table.add_row(first, second, f"{cosine:.3f}")
    console.print(table if pairs else "Every two effects can be distinguished (cosine below 0.95).")
    if found.hidden():
        console.print(f"Hidden by the tolerances of the rig: {', '.join(found.hidden())}", markup=False)
    sizes = Table("effect", "seen from this share of a plain size")
    for name, least in sorted(zip(found.effects, found.least.tolist(), strict=True), key=lambda pair: pair[1]):
        sizes.add_row(name, f"{least:.2g}")
    console.print(sizes)
    for line in advice(found, plans):
        console.print(line, markup=False)
    return 0


def read_plans(path: Path) -> list[Plan]:
    """The tests of a plan file: one test, or a list of them.

    Raises:
        PlanError: it cannot be read, or a test of it is not valid.
    """
    try:
        content: Any = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise PlanError(f"cannot be read: {error}", where=str(path), remedy="name a YAML file with a plan") from error
    if isinstance(content, dict) and "tests" in content:
        content = cast("dict[str, Any]", content)["tests"]
    listed = cast("list[Any]", content) if isinstance(content, list) else [content]
    try:
        return [_PLAN.validate_python(entry) for entry in listed]
    except ValidationError as error:
        raise PlanError(str(error), where=str(path), remedy="mend the fields above") from error
