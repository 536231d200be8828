"""`modallab campaign run`: a session at the bench from the terminal, by the same code as the service."""

import argparse
import getpass
import signal
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from modallab.cli.identify import print_remarks, result_table, show_joined
from modallab.cli.terminal_mode.keys import KeyMap, listen_to_keys
from modallab.cli.terminal_mode.operator import TerminalOperator
from modallab.core.block import Campaign
from modallab.core.errors import RigError
from modallab.core.plan import Plan
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.plan_file import read_plans
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import report_content
from modallab.pipelines.setups import identify_setups, setup_names
from modallab.reporting.report import write_report
from modallab.service.campaigns.local_session import LocalCampaign
from modallab.storage import Store
from modallab.storage.campaigns import campaigns_by_rig, rejected_blocks


def run(arguments: argparse.Namespace) -> int:
    """Run the plans in turn, identify, and show the model."""
    rig = read_rig(arguments.rig)
    url = arguments.bench or rig.bench
    if not url:
        raise RigError("names no bench", where=str(arguments.rig), remedy="give --bench ADDRESS, or a field bench")
    # Asked to end, it leaves the bench as Ctrl-C does: at rest.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    console = Console()
    runs = _record(console, rig, url, read_plans(arguments.plan), arguments)
    with Store(arguments.data) as store:
        campaigns = campaigns_by_rig(store, runs)
        if len(campaigns) > 1:
            _identify_setups(console, campaigns, arguments)
            return 0
        campaign = next(iter(campaigns))
        if arguments.out is not None:
            write_campaign(campaign, arguments.out)
        _identify(console, store, campaign, runs, arguments.report)
    return 0


def _record(console: Console, rig: Rig, url: str, plans: list[Plan], arguments: argparse.Namespace) -> tuple[str, ...]:
    keys = KeyMap.read(arguments.keys)
    operator = arguments.operator or getpass.getuser()
    with LocalCampaign(rig, url, arguments.data, arguments.name or rig.name, operator) as session:
        console.print(f"campaign {session.campaign.id} on {url}", markup=False, highlight=False)
        at_bench = TerminalOperator(console, keys, session, mute=arguments.mute)
        try:
            with listen_to_keys(keys, at_bench.handle_key) as key_pressed:
                return session.run_all(
                    plans,
                    at_bench.notify,
                    lambda: at_bench.left,
                    lambda setup, moves: at_bench.confirm_sensor_moves(setup, moves, key_pressed),
                )
        finally:
            at_bench.close()


def _identify(console: Console, store: Store, campaign: Campaign, runs: tuple[str, ...], report: Path | None) -> None:
    result = identify_campaign(campaign, IdentificationOptions())
    console.print(result_table(campaign, result))
    print_remarks(console, result)
    if report is not None:
        rejected = [pair for name in runs for pair in rejected_blocks(store, name)]
        write_report(report, report_content(campaign, result, f"Modal test of {campaign.rig.name}", rejected))


def _identify_setups(console: Console, campaigns: Sequence[Campaign], arguments: argparse.Namespace) -> None:
    """Write the file of each set-up, show their joined model, then those of other tests."""
    if arguments.out is not None:
        for name, campaign in zip(setup_names(campaigns), campaigns, strict=True):
            write_campaign(campaign, arguments.out.with_stem(f"{arguments.out.stem}-{name}"))
    struck = [campaign for campaign in campaigns if campaign.of("impact")]
    if len(struck) > 1:
        show_joined(console, identify_setups(struck, IdentificationOptions()), arguments.report)
    for campaign in campaigns:
        others = replace(campaign, blocks=tuple(b for b in campaign.blocks if len(struck) < 2 or b.test != "impact"))
        if others.blocks:
            result = identify_campaign(others, IdentificationOptions())
            console.print(result_table(others, result))
            print_remarks(console, result)
