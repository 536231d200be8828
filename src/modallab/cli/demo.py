"""`modallab demo`: both tests on the simulated bench, from the first hit to the report."""

import argparse
from pathlib import Path

from modallab.bench.simulated import simulated_bench
from modallab.cli import effects, serve
from modallab.cli.demo_rig import demo_rig
from modallab.cli.identify import print_remarks, result_table
from modallab.cli.progress import Display
from modallab.cli.saying import console_of
from modallab.core.block import Block, Campaign
from modallab.core.plan import BLOCK_S, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig, Tolerance
from modallab.formats.atomic import make_folder
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.rig.rig_file import write_rig
from modallab.identification.options import Options
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import write_models
from modallab.pipelines.report import report_content
from modallab.reporting.report import write_report
from modallab.reporting.waiting import waiting
from modallab.service.campaigns.local_session import record_campaign
from modallab.storage import Store
from modallab.storage.campaigns import rejected_blocks

DEMO_POINTS = (10, 6, 3)
"""The free end, where every mode moves, and two points where the second and third move against it."""


BESIDE = (5, 6, 28, 33, 35, 84, 92, 96)
"""Lines beside the first three resonances, driven at a second level: whether the bench answers in proportion."""
HIGH_V = 0.8
"""That level: higher by more than half, and within the limits of the rig at every seed."""


def run(arguments: argparse.Namespace) -> int:
    """Run both tests, identify, verify, and leave everything in one folder; or show the bench on the page."""
    for asked in arguments.effect or ():
        name, _, word = asked.rpartition(",")
        if word == "help":
            return effects.run(argparse.Namespace(names=[name] if name else []))
    return _on_the_page(arguments) if arguments.serve else _at_the_terminal(arguments)


def _on_the_page(arguments: argparse.Namespace) -> int:
    # In real time, so that a hit can be seen; twice as fast, since nobody waits ten minutes for a demonstration.
    bench = f"{_bench(arguments, demo_rig())}&pace=1&speed=2&zeta=0.02"
    options = dict.fromkeys((*serve.OPTIONS, "rig"), None)
    data = arguments.out / "served"
    return serve.run(argparse.Namespace(**options | {"data": data}, bench=bench, open=True))


def _bench(arguments: argparse.Namespace, rig: Rig) -> str:
    built = "none" if arguments.clean else "usual"
    return simulated_bench(rig, arguments.seed, arguments.effect or (), built)


def _at_the_terminal(arguments: argparse.Namespace) -> int:
    folder: Path = arguments.out
    rig = demo_rig() if arguments.clean else _as_built(demo_rig())
    url = _bench(arguments, rig)
    make_folder(folder)
    console = console_of(arguments)
    console.print(f"bench {url}: {rig.name}, both tests", markup=False)
    with Display(console) as display:
        campaign = record_campaign(url, rig, demo_plans(), folder / "data", display.notify)
    console.print("identifying ...")
    with waiting("identifying", progress=not arguments.hush):
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


def _as_built(rig: Rig) -> Rig:
    """The rig with the tolerances of an ordinary lab: no real bench is clean."""
    return rig.model_copy(update={"tolerance": Tolerance.usual()})


def demo_plans() -> tuple[Plan, ...]:
    """The impact test, five hits at each of three points, and the sine test, 24 frequencies and some again, higher."""
    again = tuple(n / BLOCK_S for n in BESIDE)
    return (
        ImpactPlan(points=DEMO_POINTS, hits=5),
        SinePlan(),
        SinePlan(frequencies_hz=again, levels_v={"high": HIGH_V}),
    )


def _rejected(folder: Path, campaign: Campaign) -> list[tuple[Block, str]]:
    with Store(folder / "data") as store:
        return [pair for run_id in campaign.provenance["runs"].split() for pair in rejected_blocks(store, run_id)]
