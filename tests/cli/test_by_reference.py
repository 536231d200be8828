"""A structure held beside its modal model from before, by the command."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from twin_campaign import built, link

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.formats.campaign.campaign_hdf5 import write_campaign

MASS = Effect(effect="added_mass", parameters={"mass": 0.15}, place={"x": 0.8})


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., str]:
    def written(name: str, *effects: Effect) -> str:
        campaign: Campaign = built(link(), *effects, tests=("impact",))
        path: Path = tmp_path_factory.mktemp(name) / "campaign.h5"
        write_campaign(campaign, path)
        return str(path)

    return written


def test_a_mass_that_came_later_is_found_beside_the_campaign_from_before(
    recorded: Callable[..., str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before, after, out = recorded("before"), recorded("after", MASS), tmp_path / "found.json"
    assert main(["gap", "diagnose", after, "--reference", before, "--json", str(out), "--quiet"]) == 0
    found = json.loads(out.read_text(encoding="utf-8"))
    assert found["verdict"] == "known"
    (effect,) = found["effects"]
    assert effect["effect"] == "added_mass"
    assert effect["place"]["at_m"][0] == pytest.approx(0.8, abs=0.05)
    assert effect["parameters"]["mass"] == pytest.approx(0.15, rel=0.25)
    capsys.readouterr()
    assert main(["gap", "diagnose", before, "--reference", before]) == 0
    assert "No gap beyond the tolerances" in " ".join(capsys.readouterr().out.split())
