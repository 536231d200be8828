"""`modallab gap`: diagnose a campaign, predict another, or say beforehand what a plan can distinguish."""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from pydantic import ValidationError
from rich.console import Console
from rich.table import Table

from modallab.acquisition.procedures.plan_checks import require_possible
from modallab.bench.protocol import BenchInfo
from modallab.cli.console import console_of, write_json
from modallab.cli.options import require_option
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import FormatError, PlanError
from modallab.core.frozen import Frozen
from modallab.core.hold_out import HoldOut
from modallab.core.plan import ImpactPlan, Plan
from modallab.core.rig import Rig
from modallab.core.setups import rig_in_set_up, split_setups
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.plan_file import read_plans
from modallab.formats.prediction import read_prediction, write_prediction
from modallab.formats.rig.rig_file import read_rig
from modallab.gap.design.distinguishability import advice_on_plan, distinguishability_of_plan
from modallab.gap.design.prediction import predict_records, predicted_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.simulations.compare import compare_simulation
from modallab.gap.words.verdicts import gap_in_percent, sentence_by_model, sentence_of_simulation, verdict_sentence
from modallab.reporting.gap_report import write_gap_report
from modallab.reporting.simulation_report import write_simulation_report
from modallab.reporting.waiting_line import waiting_line
from modallab.service.campaigns.run_start import require_sensible_numbers

_ANY_BENCH = BenchInfo(url="", devices=(), can_drive=True, real_time=False, facts={})
"""No bench is asked: what the rig itself forbids is all that can be said."""
MOST_SAMPLES = 1 << 17
"""Of a block; a longer one is computed for minutes, and usually is a slip in a unit."""
_DIAGNOSE = "write one with modallab gap diagnose CAMPAIGN --json FILE"


def run(arguments: argparse.Namespace) -> int:
    """Run the chosen one of the three."""
    return {"diagnose": _diagnose, "predict": _predict, "distinguishability": _distinguishability}[arguments.action](
        arguments
    )


def _diagnose(arguments: argparse.Namespace) -> int:
    if arguments.simulation is None:
        require_option("--simulation", diagnosis=arguments.diagnosis)
    if arguments.reference is None:
        require_option("--reference", band=arguments.band)
    campaign = read_campaign(arguments.campaign, None if arguments.rig is None else read_rig(arguments.rig))
    console = console_of(arguments)
    if arguments.simulation is not None:
        return _compare(console, campaign, arguments)
    if arguments.reference is not None:
        return _compare_with_model(console, campaign, arguments)
    with waiting_line("reading the records", progress=not arguments.hush):
        diagnosis = diagnose(campaign, HoldOut.parse(arguments.hold_out))
    console.print(verdict_sentence(diagnosis, [c.name for c in campaign.rig.channels]), markup=False)
    calibrate = diagnosis.budget.calibrate if diagnosis.budget is not None else []
    next_one = f"Next: {diagnosis.next_experiment}"
    for line in (gap_in_percent(diagnosis.gap), *diagnosis.where.why, *diagnosis.notes, *calibrate, next_one):
        console.print(f"  {line}", markup=False)
    return _keep_result(console, arguments, diagnosis, lambda report: write_gap_report(report, diagnosis, campaign))


def _compare(console: Console, campaign: Campaign, arguments: argparse.Namespace) -> int:
    records = read_prediction(arguments.simulation, campaign.rig)
    known = None if arguments.diagnosis is None else read_diagnosis(arguments.diagnosis)
    with waiting_line("reading the records", progress=not arguments.hush):
        found = compare_simulation(campaign, records, known, HoldOut.parse(arguments.hold_out))
    for line in (sentence_of_simulation(found), *(f"  {note}" for note in found.notes)):
        console.print(line, markup=False)
    return _keep_result(console, arguments, found, lambda report: write_simulation_report(report, found))


def _compare_with_model(console: Console, campaign: Campaign, arguments: argparse.Namespace) -> int:
    # Imported here: the other ways of a diagnosis need no identification, which takes a second to load.
    from modallab.pipelines.structure_gap import gap_against
    from modallab.reporting.structure_report import write_structure_report

    with waiting_line("identifying", progress=not arguments.hush):
        gap = gap_against(campaign, arguments.reference, arguments.band and tuple(arguments.band))
    found = gap.diagnosis
    for line in (sentence_by_model(found), *(f"  {note}" for note in found.notes)):
        console.print(line, markup=False)
    return _keep_result(console, arguments, found, lambda report: write_structure_report(report, gap))


def _keep_result(
    console: Console, arguments: argparse.Namespace, found: Frozen, write_report: Callable[[Path], object]
) -> int:
    if arguments.json is not None:
        write_json(arguments.json, found.model_dump(mode="json"))
    if arguments.report is not None:
        write_report(arguments.report)
        console.print(f"report: {arguments.report}", markup=False)
    return 0


def _predict(arguments: argparse.Namespace) -> int:
    diagnosis = read_diagnosis(arguments.diagnosis)
    read_campaign(arguments.campaign)
    other = read_campaign(arguments.on)
    records = predict_records(diagnosis, other)
    write_prediction(arguments.out, other.rig, records)
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
        text = path.read_text(encoding="utf-8")
        if '"models"' in text and '"verdict"' not in text:
            raise FormatError("holds modal models, not a diagnosis", where=str(path), remedy=_DIAGNOSE)
        return Diagnosis.model_validate_json(text)
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}", where=str(path), remedy="name a diagnosis") from error
    except UnicodeDecodeError as error:
        raise FormatError("is no diagnosis, and no text file", where=str(path), remedy=_DIAGNOSE) from error
    except ValidationError as error:
        first = ".".join(map(str, error.errors()[0]["loc"]))
        count = error.error_count()
        raise FormatError(
            f"is no diagnosis: {count} fields are missing or wrong, the first is {first}"
            if first
            else "is no diagnosis: no JSON object",
            where=str(path),
            remedy=_DIAGNOSE,
        ) from error


def _distinguishability(arguments: argparse.Namespace) -> int:
    rig, plans = read_rig(arguments.rig), read_plans(arguments.plan)
    _require_plans(rig, plans)
    found = distinguishability_of_plan(rig, plans)
    console = Console()
    pairs = found.indistinguishable_pairs()
    table = Table("effect", "and", "largest cosine of their signatures")
    for first, second, cosine in pairs:
        table.add_row(first, second, f"{cosine:.3f}")
    console.print(table if pairs else "Every two effects can be distinguished (cosine below 0.95).")
    if found.hidden_effects():
        console.print(f"Hidden by the tolerances of the rig: {', '.join(found.hidden_effects())}", markup=False)
    sizes = Table("effect", "smallest detectable size, relative to a usual size")
    for name, least in sorted(
        zip(found.effects, found.smallest_visible.tolist(), strict=True), key=lambda pair: pair[1]
    ):
        sizes.add_row(name, f"{least:.2g}")
    console.print(sizes)
    for line in advice_on_plan(found, plans):
        console.print(line, markup=False)
    return 0


def _require_plans(rig: Rig, plans: Sequence[Plan]) -> None:
    """Reject what could not be run either: its unit is wrong, or the rig does not allow it.

    Raises:
        PlanError: what is wrong.
    """
    for plan in plans:
        require_sensible_numbers(plan, rig)
        for part in split_setups(plan) if isinstance(plan, ImpactPlan) else (plan,):
            stands = rig_in_set_up(rig, part.setups[0]) if isinstance(part, ImpactPlan) and part.setups else rig
            require_possible(part, stands, _ANY_BENCH)
        samples = plan.block_s * plan.rate_hz
        if samples > MOST_SAMPLES:
            raise PlanError(
                f"block_s {plan.block_s:g} at rate_hz {plan.rate_hz:g} is {samples:g} samples; allowed: {MOST_SAMPLES}",
                where=f"{plan.kind} plan",
                remedy="write block_s in s and rate_hz in Hz",
            )
