"""`modallab campaign run` as an operator types it: progress while it goes on, then the model, the file, the report."""

import signal
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from modallab.cli import main
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.storage import Store

BENCH = "sim://cantilever?seed=1&bad_hits=0&effect=gain_error,gain=0.7,channel=6"
PLAN = "- {kind: impact, points: [10, 3], hits: 2}\n"


@pytest.fixture
def command(tmp_path: Path) -> Iterator[list[str]]:
    """The command with its rig and its plan; it takes over SIGTERM, which is given back."""
    before = signal.getsignal(signal.SIGTERM)
    rig, plan = tmp_path / "rig.yaml", tmp_path / "plan.yaml"
    rig.write_bytes((resources.files("modallab.cli") / "link_rig.yaml").read_bytes())
    plan.write_text(PLAN, encoding="utf-8")
    yield ["campaign", "run", "--rig", str(rig), "--plan", str(plan), "--data", str(tmp_path / "data")]
    signal.signal(signal.SIGTERM, before)


def test_a_session_from_the_terminal_says_during_the_test_which_sensor_differs_from_the_simulation(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, report = tmp_path / "session.h5", tmp_path / "session.html"
    requests = ["--bench", BENCH, "--name", "first", "--operator", "Ada", "--out", str(file), "--report", str(report)]
    assert main([*command, *requests]) == 0
    said = capsys.readouterr().out
    assert BENCH in said
    # The bar: all four hits of the plan.
    assert "4/4" in said
    assert "4.75" in said
    differs = "The response of a06 (32 %) differs from the simulation; the other channels agree."
    assert differs in " ".join(said.split())
    assert "<html" in report.read_text(encoding="utf-8")
    campaign = read_campaign(file)
    with Store(tmp_path / "data") as store:
        (run,) = store.catalogue.runs()
        blocks = store.blocks(run.id)
    assert run.state == "done"
    assert len(campaign.blocks) == len(blocks) == 4
    for written, kept in zip(campaign.blocks, blocks, strict=True):
        np.testing.assert_array_equal(written.samples, kept.samples)


def test_a_plan_the_rig_cannot_do_is_rejected_before_anything_moves(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plan.yaml").write_text("- {kind: impact, points: [99], hits: 2}\n", encoding="utf-8")
    assert main([*command, "--bench", BENCH]) == 2
    reported = capsys.readouterr()
    assert "99" in reported.err
    with Store(tmp_path / "data") as store:
        assert all(not store.blocks(run.id) for run in store.catalogue.runs())
