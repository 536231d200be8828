"""A structure held beside its modal model from before, by the command."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from beam_elements import beam
from twin_campaign import built, link

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig, Tolerance
from modallab.formats.campaign.campaign_hdf5 import write_campaign

MASS = Effect(effect="added_mass", parameters={"mass": 0.15}, place={"x": 0.8})


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., str]:
    def written(name: str, *effects: Effect, usual: bool = False) -> str:
        campaign: Campaign = built(link(), *effects, tests=("impact",))
        if usual:
            rig = campaign.rig.model_copy(update={"tolerance": Tolerance.usual()})
            campaign = replace(campaign, rig=rig)
        path: Path = tmp_path_factory.mktemp(name) / "campaign.h5"
        write_campaign(campaign, path)
        return str(path)

    return written


@pytest.mark.thorough("records two whole tests, and fits a finite-element model")
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
    page = tmp_path / "found.html"
    assert main(["gap", "diagnose", before, "--reference", before, "--report", str(page)]) == 0
    assert "an earlier campaign, campaign.h5" in page.read_text(encoding="utf-8")
    assert "No gap beyond the tolerances" in " ".join(capsys.readouterr().out.split())


def elements_of(rig: Rig) -> dict[str, np.ndarray]:
    """K, M, freedoms and nodes of the beam that a rig file describes, with the sensors' masses."""
    assert rig.beam is not None
    stiff, per_m = rig.beam.bending_stiffness_n_m2, rig.beam.mass_kg / rig.beam.length_m
    k, m, freedoms, nodes = beam(stiff, per_m, rig.beam.length_m, 20)
    for channel in rig.responses:
        place = int(np.argmin(np.abs(nodes[:, 1] - rig.x_of(channel.point or 0))))
        m[2 * place, 2 * place] += channel.mass_kg
    return {"K": k, "M": m, "dof": freedoms, "nodes": nodes}


@pytest.mark.thorough("diagnoses a whole campaign beside a finite-element model")
def test_a_mass_is_found_beside_a_finite_element_model_that_is_too_soft_by_a_tenth(
    recorded: Callable[..., str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = tmp_path / "beam.npz", tmp_path / "found.json"
    elements = elements_of(link())
    np.savez(model, **elements | {"K": 0.9 * elements["K"]})
    assert (
        main(["gap", "diagnose", recorded("after", MASS, usual=True), "--reference", str(model), "--json", str(out)])
        == 0
    )
    (effect,) = json.loads(out.read_text(encoding="utf-8"))["effects"]
    assert effect["effect"] == "added_mass"
    assert effect["place"]["at_m"][0] == pytest.approx(0.8, abs=0.05)
    assert effect["parameters"]["mass"] == pytest.approx(0.15, rel=0.25)
    assert "The bench is stiffer than the reference as a whole" in " ".join(capsys.readouterr().out.split())
    # These elements have no rotary inertia, which lowers the seventh mode by 0.1 %: a usual tolerance.
    assert main(["gap", "diagnose", recorded("before", usual=True), "--reference", str(model)]) == 0
    assert "No gap beyond the tolerances" in " ".join(capsys.readouterr().out.split())


def test_a_model_in_millimetres_says_which_point_is_nowhere(
    recorded: Callable[..., str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    held = elements_of(link())
    np.savez(tmp_path / "beam.npz", **(held | {"nodes": held["nodes"] * [1, 1e3, 1e3, 1e3]}))
    assert main(["gap", "diagnose", recorded("before"), "--reference", str(tmp_path / "beam.npz")]) == 2
    assert "units: mm if that is its unit" in " ".join(capsys.readouterr().err.split())
