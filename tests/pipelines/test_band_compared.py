"""A comparison in a band sees what lies in it."""

from pathlib import Path

import numpy as np
import pytest

from modallab.blind.measured.draw import MeasuredRequest
from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.pipelines.structure_gap import gap_against
from modallab.pipelines.structure_trials import trials_on

LINES = np.arange(10, 95, 0.125)
FORCE = Channel(index=0, name="force", quantity="force", unit="N", point=1)
SENSOR = Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1)
RIG = Rig(name="one sensor", model="unknown", points=(Point(id=1, x_m=0.0),), channels=(FORCE, SENSOR))


def campaign(upper_hz: float) -> Campaign:
    """Modes at 30 Hz and at `upper_hz`, of 1 kg each, with noise."""
    w, rng = 2 * np.pi * LINES, np.random.default_rng(int(upper_hz))
    each = [-(w**2) / (w0**2 - w**2 + 0.02j * w0 * w) for w0 in 2 * np.pi * np.array([30.0, upper_hz])]
    values = sum(each) + 1e-3 * (rng.normal(size=(LINES.size, 2)) @ [1, 1j])
    frf = Frf(LINES, values[None, None], "inertance", ("a1",), (1,), (1,), variance=np.full((1, 1, LINES.size), 2e-6))
    return Campaign(RIG, (), (frf,), source="one.h5")


@pytest.mark.thorough("identifies and compares two campaigns")
def test_what_changed_beyond_the_band_is_no_gap_in_it(tmp_path: Path) -> None:
    before, after = tmp_path / "before.h5", campaign(90.0)
    write_campaign(campaign(80.0), before)
    below = gap_against(after, before, (10.0, 45.0)).diagnosis
    assert (below.verdict, below.modes) == ("no_gap", (1, 1))
    assert gap_against(after, before).diagnosis.verdict != "no_gap"


def test_trials_are_made_of_the_lines_in_their_band(tmp_path: Path) -> None:
    empty = MeasuredRequest(trials=0, none=1, band_hz=(20.0, 20.5))
    with pytest.raises(IdentificationError, match="5 lines"):
        trials_on(campaign(80.0), tmp_path / "empty", empty)
    found = trials_on(campaign(80.0), tmp_path / "below", MeasuredRequest(trials=0, none=1, band_hz=(10.0, 45.0)))
    assert [t.said for t in found.trials] == ["no_gap"]


def test_a_band_without_a_reference_is_rejected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_campaign(campaign(80.0), tmp_path / "c.h5")
    assert main(["gap", "diagnose", str(tmp_path / "c.h5"), "--band", "10", "45"]) == 2
    assert "--reference" in capsys.readouterr().err
