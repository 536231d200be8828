"""`modallab demo`: both tests on the simulated bench, from the first hit to the report."""

import argparse
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from modallab.bench.loader import simulated_bench
from modallab.cli.background_result import BackgroundResult
from modallab.cli.console import ProgressDisplay, console_of
from modallab.core.block import Campaign
from modallab.core.plan import BLOCK_S, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig, Tolerance
from modallab.formats.atomic import make_folder
from modallab.formats.rig.rig_file import parse_rig
from modallab.service.campaigns.local_session import LocalCampaign, local_user

if TYPE_CHECKING:
    from modallab.pipelines.identify import IdentifiedTest


def run(arguments: argparse.Namespace) -> int:
    """Run both tests, identify, verify, and leave everything in one folder; or show the bench on the page."""
    for asked in arguments.effect or ():
        name, _, word = asked.rpartition(",")
        if word == "help":
            from modallab.cli import effects

            return effects.run(argparse.Namespace(names=[name] if name else []))
    return _demo_on_page(arguments) if arguments.serve else _demo_at_terminal(arguments)


def _demo_on_page(arguments: argparse.Namespace) -> int:
    from modallab.cli import serve

    # In real time, so that a hit can be seen; twice as fast, since nobody waits ten minutes for a demonstration.
    bench = f"{_demo_bench(arguments, demo_rig())}&pace=1&speed=2&zeta=0.02"
    options = dict.fromkeys((*serve.OPTIONS, "rig"), None)
    data = arguments.out / "served"
    return serve.run(argparse.Namespace(**options | {"data": data}, bench=bench, open=True))


def _demo_bench(arguments: argparse.Namespace, rig: Rig) -> str:
    built = "none" if arguments.clean else "usual"
    return simulated_bench(rig, arguments.seed, arguments.effect or (), built)


def _demo_at_terminal(arguments: argparse.Namespace) -> int:
    folder: Path = arguments.out
    rig = demo_rig() if arguments.clean else _rig_as_built(demo_rig())
    url = _demo_bench(arguments, rig)
    make_folder(folder)
    console = console_of(arguments)
    console.print(f"bench {url}: {rig.name}, both tests", markup=False)
    # What identifies and draws takes as long to load as the bench to begin.
    BackgroundResult(lambda: import_module("modallab.cli.demo_results"))
    with (
        ProgressDisplay(console) as display,
        LocalCampaign(rig, url, folder / "data", rig.name, local_user()) as session,
    ):
        hammer, *shaker = demo_plans()
        runs = session.run_all([hammer], display.notify)
        struck = session.recorded(runs)
        # The bench computes in its own process: meanwhile this one need not wait.
        computed = BackgroundResult(lambda: _identify_demo(struck))
        campaign = session.recorded((*runs, *session.run_all(shaker, display.notify)))
    from modallab.cli.demo_results import write_demo_results

    write_demo_results(arguments, campaign, computed)
    return 0


def _identify_demo(campaign: Campaign) -> "IdentifiedTest":
    from modallab.cli.demo_results import identify_test

    return identify_test(campaign, "impact")


def _rig_as_built(rig: Rig) -> Rig:
    """The rig with the tolerances of an ordinary lab: no real bench is clean."""
    return rig.model_copy(update={"tolerance": Tolerance.usual()})


DEMO_POINTS = (10, 6, 3)
"""The free end, where every mode moves, and two points where the second and third move against it."""
BESIDE = (5, 6, 28, 33, 35, 84, 92, 96)
"""Lines beside the first three resonances, driven at a second level: whether the bench answers in proportion."""
HIGH_V = 0.8
"""That level: higher by more than half, and within the limits of the rig at every seed."""


def demo_rig() -> Rig:
    """The paper's link as a rig."""
    resource = files("modallab.cli").joinpath("link_rig.yaml")
    return parse_rig(resource.read_text(encoding="utf-8"), "the demo's rig")


def demo_plans() -> tuple[Plan, ...]:
    """The impact test, five hits at each of three points, and the sine test, 24 frequencies and some again, higher."""
    again = tuple(n / BLOCK_S for n in BESIDE)
    return (
        ImpactPlan(points=DEMO_POINTS, hits=5),
        SinePlan(),
        SinePlan(frequencies_hz=again, levels_v={"high": HIGH_V}),
    )
