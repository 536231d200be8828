"""The pictures of the pages can be drawn again by the command that says so."""

import runpy
from pathlib import Path

import pytest
from pages import ROOT

from modallab.formats.campaign.campaign_hdf5 import read_campaign


@pytest.mark.thorough("draws every picture of the pages")
def test_every_picture_is_drawn_from_a_campaign_of_the_demo(demo: Path, tmp_path: Path) -> None:
    script = runpy.run_path(str(ROOT / "docs/images/make.py"))
    drawn = script["pictures"](read_campaign(demo / "campaign.h5"))
    assert {f"{name}.svg" for name in drawn} == {p.name for p in (ROOT / "docs/images").glob("*.svg")}
    for name, figure in drawn.items():
        script["write"](figure, tmp_path / f"{name}.svg", name)
        assert 10_000 < (tmp_path / f"{name}.svg").stat().st_size < 200_000
