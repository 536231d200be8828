"""Identify, report and diagnose as jobs: by a real worker, with the same numbers as in this process."""

import json
from pathlib import Path

import numpy as np
import pytest
from twin_campaign import built, link
from waiting import ended

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.errors import JobError, StorageError
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.options import IdentificationOptions
from modallab.jobs import Jobs
from modallab.jobs.runner import JobRunner
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.job_kinds import kinds
from modallab.pipelines.parameters import DiagnoseParameters, parse_parameters

MASS = Effect(effect="added_mass", parameters={"mass": 0.15}, place={"x": 0.8})
DATA = Path(__file__).parents[1] / "data"


def _mass_later(inputs: tuple[str, ...]) -> Campaign:
    (name,) = inputs
    return built(link(), *(MASS,) * (name == "today"), tests=("impact",))


def _campaign(inputs: tuple[str, ...]) -> Campaign:
    (name,) = inputs
    if name == "link":
        return built(link(), tests=("impact",))
    if name != "hammer_5hits":
        raise StorageError(f"there is no run {name!r}", remedy="read the list of runs")
    return read_campaign(DATA / "hammer_5hits.h5", read_rig(DATA / "hammer_rig.yaml"))


@pytest.mark.thorough("computes every kind of job in a worker")
def test_identify_and_report_give_what_they_give_in_this_process(jobs: Jobs, tmp_path: Path) -> None:
    here = identify_campaign(
        _campaign(("hammer_5hits",)), IdentificationOptions(method="peak", band_hz=(500.0, 1500.0))
    )
    with JobRunner(jobs, kinds(_campaign, tmp_path), workers=1):
        inputs = ["hammer_5hits"]
        identified, reported, wrong, absent, bad, estimated = ended(
            jobs,
            jobs.submit("identify", {"method": "peak", "band_hz": [500, 1500]}, inputs),
            jobs.submit("report", {"method": "peak", "band_hz": [500, 1500], "title": "A heading of its own"}, inputs),
            jobs.submit("identify", {"method": "magic"}, inputs),
            jobs.submit("identify", {}, ["nothing"]),
            jobs.submit("diagnose", {}, inputs),
            jobs.submit("estimate", {}, ["link"]),
            patience_s=120,
        )
    assert (identified.state, identified.error) == ("done", None)
    (model,) = identified.result["document"]["models"]
    np.testing.assert_array_equal(np.array(model["frequency_hz"], dtype=float), here.identified[0].model.frequency_hz)
    np.testing.assert_array_equal(np.array(model["damping_ratio"], dtype=float), here.identified[0].model.damping_ratio)
    assert set(identified.result["files"]) == {"curves.json"}
    assert reported.result["document"] == identified.result["document"]
    page = (tmp_path / reported.result["files"]["report.html"]).read_text(encoding="utf-8")
    assert "<h1>A heading of its own</h1>" in page
    so_far = estimated.result["document"]
    assert so_far["blocks"] == 6
    assert so_far["frequency_hz"][0] == pytest.approx(4.97, abs=0.01)
    assert so_far["agreement"]["agrees"]
    assert so_far["agreement"]["sentence"].startswith("The simulation agrees with all 10 channels")
    # At the tip no mode has a node.
    assert so_far["telling_point"] == max(link().points, key=lambda point: point.x_m).id
    assert (wrong.state, absent.state) == ("failed", "failed")
    assert "allowed: 'circle', 'era', 'peak' or 'plscf'" in str(wrong.error)
    assert "there is no run 'nothing'" in str(absent.error)
    # This rig file describes no beam, so that there is nothing to hold the recording against.
    assert bad.state == "failed"
    assert "the rig file has no beam" in str(bad.error)


def test_parameters_are_checked_before_a_job_is_ordered() -> None:
    parsed = parse_parameters("diagnose", {"hold_out": "point:3"})
    assert parsed == DiagnoseParameters(hold_out="point:3")
    assert json.loads(parse_parameters("identify", {"band_hz": [3, 110]}).model_dump_json())["band_hz"] == [3, 110]
    for kind, given in (
        ("dance", {}),
        ("diagnose", {"hold_out": "all"}),
        ("diagnose", {"reference": "run-1"}),
        ("diagnose", {"band_hz": [3, 110]}),
        ("identify", {"order": 3}),
        ("identify", {"band_hz": [float("nan"), 3]}),
    ):
        with pytest.raises(JobError):
            parse_parameters(kind, given)


@pytest.mark.thorough("diagnoses as a job")
def test_runs_from_before_stand_for_the_simulation(jobs: Jobs, tmp_path: Path) -> None:
    with JobRunner(jobs, kinds(_mass_later, tmp_path), workers=1):
        found, alone = ended(
            jobs,
            jobs.submit("diagnose", {"reference": ["before"]}, ["before", "today"]),
            jobs.submit("diagnose", {"reference": ["before"]}, ["before"]),
            patience_s=120,
        )
    assert found.error is None
    (effect,) = found.result["document"]["effects"]
    assert effect["effect"] == "added_mass"
    assert "an earlier campaign" in (tmp_path / found.result["files"]["gap.html"]).read_text(encoding="utf-8")
    assert "all runs are earlier ones" in str(alone.error)
