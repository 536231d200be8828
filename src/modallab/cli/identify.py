"""`modallab identify`: the modal model of a campaign."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from modallab.cli.console import console_of, write_json
from modallab.cli.outputs import OUT
from modallab.core.block import Campaign
from modallab.core.errors import ConfigurationError
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.estimator import USUAL
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod
from modallab.identification.selection.assumptions import CANNOT_BE_SAID
from modallab.identification.setups.compare import ComparedSetUp
from modallab.identification.setups.readings import SetUpReading
from modallab.pipelines.identify import CampaignResult
from modallab.pipelines.model_file import model_document
from modallab.pipelines.report import modes_as_built, report_content
from modallab.pipelines.response_only import identify_chosen
from modallab.pipelines.response_setups import identify_response_setups
from modallab.pipelines.setups import JoinedSetups, identify_setups
from modallab.reporting.report import write_report
from modallab.reporting.table import modal_table
from modallab.reporting.waiting_line import waiting_line


def run(arguments: argparse.Namespace) -> int:
    """Identify, print the table, and write what was asked for."""
    rig = None if arguments.rig is None else read_rig(arguments.rig)
    campaigns = [read_campaign(path, rig) for path in arguments.campaign]
    options, console = _options(arguments), console_of(arguments)
    if arguments.response_only:
        _require_plain(arguments)
    if len(campaigns) > 1 and (arguments.response_only or all(c.rig.force is None for c in campaigns)):
        _, how = response_choice(arguments.response_only)
        with waiting_line("identifying", progress=not arguments.hush):
            merged = identify_response_setups(campaigns, options, arguments.test, how)
        _show(console, merged.campaign, merged.result, arguments, merged.readings)
        return 0
    if len(campaigns) > 1:
        with waiting_line("identifying", progress=not arguments.hush):
            joined = identify_setups(campaigns, options)
        show_joined(console, joined, arguments.report)
        if arguments.json is not None:
            write_json(arguments.json, model_document(joined.campaign, joined.result))
        return 0
    (campaign,) = campaigns
    alone, how = response_choice(arguments.response_only)
    with waiting_line("identifying", progress=not arguments.hush):
        result = identify_chosen(campaign, options, arguments.test, response_only=alone, method=how)
    _show(console, campaign, result, arguments)
    return 0


def _options(arguments: argparse.Namespace) -> IdentificationOptions:
    return IdentificationOptions(
        method=arguments.method,
        band_hz=None if arguments.band is None else (float(arguments.band[0]), float(arguments.band[1])),
        max_order=arguments.order,
        pick_hz=tuple(arguments.pick or ()),
        drop_hz=tuple(arguments.drop or ()),
        refine=arguments.refine,
        frf=arguments.frf,
    )


def _show(
    console: Console,
    campaign: Campaign,
    result: CampaignResult,
    arguments: argparse.Namespace,
    setups: Sequence[SetUpReading] = (),
) -> None:
    console.print(result_table(campaign, result))
    print_remarks(console, result)
    if arguments.json is not None:
        write_json(arguments.json, model_document(campaign, result))
        if arguments.json != OUT:
            console.print(f"models: {arguments.json}", markup=False)
    if arguments.report is not None:
        title = f"Modal test of {campaign.rig.name}"
        write_report(arguments.report, report_content(campaign, result, title, setups=setups))
        console.print(f"report: {arguments.report}", markup=False)


def response_choice(said: ResponseMethod | None) -> tuple[bool | None, ResponseMethod]:
    """Whether the responses alone are asked for, None for where no force was measured; and how."""
    return (None, USUAL_RESPONSE) if said is None else (True, said)


def _require_plain(arguments: argparse.Namespace) -> None:
    """Reject what the identification of responses alone has no place for."""
    given = {
        "--method": arguments.method != USUAL,
        "--refine": arguments.refine is not None,
        "--order": arguments.order is not None,
        "--pick": arguments.pick is not None,
        "--drop": arguments.drop is not None,
        "--frf": arguments.frf != "H1",
    }
    named = [name for name, there in given.items() if there]
    if named:
        raise ConfigurationError(
            f"--response-only cannot be combined with {', '.join(named)}",
            remedy="leave it out; --band, --test and --report remain",
        )


def show_joined(console: Console, joined: JoinedSetups, report: Path | None) -> None:
    """The joined model of several set-ups, how far they agree, and the report if one is asked for."""
    console.print(result_table(joined.campaign, joined.result))
    console.print(setups_table(joined.compared))
    print_remarks(console, joined.result)
    if report is not None:
        title = f"Modal test of {joined.campaign.rig.name}"
        write_report(report, report_content(joined.campaign, joined.result, title, setups=joined.readings))
        console.print(f"report: {report}", markup=False)


def setups_table(compared: Sequence[ComparedSetUp]) -> Table:
    """Frequency shift of every mode in every set-up, and the amplitude that the reference reads, in % and sigmas."""
    table = Table("set-up", "against", "mode", "frequency [%]", "sigmas", "reference [%]", "sigmas")
    for item in compared:
        for r in range(item.shift.size if item.name != item.against else 0):
            shift, ratio = 100 * item.shift[r], 100 * (item.ratio[r] - 1)
            table.add_row(
                item.name,
                item.against,
                str(r + 1),
                f"{shift:+.2g}",
                f"{item.shift_sigmas[r]:+.1f}",
                f"{ratio:+.2g}",
                f"{item.ratio_sigmas[r]:+.1f}",
            )
    return table


def result_table(campaign: Campaign, result: CampaignResult) -> Table:
    """The modes of every test, with the truth where the campaign knows it."""
    items = result.identified
    confidence = [None if item.assessment is None else item.assessment.confidence for item in items]
    return modal_table([item.model for item in items], modes_as_built(campaign), confidence)


def print_remarks(console: Console, result: CampaignResult) -> None:
    """FRAC, notes and what is not available, a line each."""
    for item in result.identified:
        if item.verification is not None:
            least = float(item.verification.frac.min())
            band = f"{item.model.band_hz[0]:.4g} to {item.model.band_hz[1]:.4g} Hz"
            console.print(f"{item.source}: FRAC of the regenerated FRFs at least {least:.4f}, {band}", markup=False)
        if item.assessment is not None:
            for verdict in item.assessment.verdicts:
                holds = "holds" if verdict.holds else "DOES NOT HOLD"
                console.print(f"{item.source}: {verdict.assumption} {holds}: {verdict.words}", markup=False)
            for assumption, why in item.assessment.unjudged:
                if why.startswith(CANNOT_BE_SAID):
                    console.print(f"{item.source}: {assumption} {why}", markup=False)
        for note in (*item.model.notes, item.model.shapes_unavailable):
            if note:
                console.print(f"{item.source}: {note}", markup=False)
    for item in result.unidentified:
        console.print(f"{item.source}: no model: {item.error}", markup=False)
