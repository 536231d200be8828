"""The pictures of the pages can be drawn anew by the command that says so."""

import runpy
from pathlib import Path

from pages import ROOT

from modallab.acquisition.process.run import record
from modallab.bench.loader import open_bench
from modallab.cli.demo_rig import demo_rig
from modallab.core.plan import ImpactPlan, SinePlan
from modallab.storage import Store, campaign_of


def test_every_picture_is_drawn_from_a_campaign_of_the_demo(tmp_path: Path) -> None:
    script = runpy.run_path(str(ROOT / "docs/images/make.py"))
    rig = demo_rig()
    bench = open_bench("sim://cantilever?seed=2", rig)
    with Store(tmp_path / "data") as store:
        runs = [
            record(bench, rig, plan, store, lambda _: None) for plan in (ImpactPlan(points=(10, 6), hits=1), SinePlan())
        ]
        drawn = script["pictures"](campaign_of(store, runs))
    assert {f"{name}.svg" for name in drawn} == {p.name for p in (ROOT / "docs/images").glob("*.svg")}
    for name, figure in drawn.items():
        script["write"](figure, tmp_path / f"{name}.svg", name)
        assert 10_000 < (tmp_path / f"{name}.svg").stat().st_size < 200_000
