"""What the project's own recorder takes on its own bench: no gap where nothing is wrong, else the effect by name."""

from pathlib import Path

import numpy as np
import pytest

from modallab.cli.demo import demo_rig
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.plan import BLOCK_S, ImpactPlan, SinePlan
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.gap.diagnosis import diagnose
from modallab.service.campaigns.local_session import record_campaign

LINES = (5, 24, 31, 60, 90)
# Bursts that are shorter than any default: mode 1 still rings in every block, at a tenth of the response.
PLANS = (
    ImpactPlan(points=(10, 6, 3), hits=2),
    SinePlan(frequencies_hz=tuple(k / BLOCK_S for k in LINES), ramp_s=0.4, settle_s=2.5, wait_s=8.0),
)


def recorded(folder: Path, effect: str = "") -> Campaign:
    url = f"sim://cantilever?seed=5&bad_hits=0{effect and f'&effect={effect}'}"
    campaign = record_campaign(url, demo_rig(), PLANS, folder / "data", lambda _: None)
    write_campaign(campaign, folder / "campaign.h5")
    return read_campaign(folder / "campaign.h5")


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return recorded(tmp_path_factory.mktemp("sound"))


@pytest.fixture(scope="module")
def massed(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return diagnose(recorded(tmp_path_factory.mktemp("massed"), "added_mass,mass=0.04,x=0.63"))


def test_every_sine_block_says_how_it_came_about(sound: Campaign) -> None:
    reported = [(b.history_s, b.ramp_s, b.ramp) for b in sound.blocks if b.test == "sine"]
    assert reported == [(2.5, 0.4, "cosine")] * len(LINES)
    assert {(b.history_s, b.ramp_s, b.ramp) for b in sound.blocks if b.test == "impact"} == {(None, None, None)}


def test_a_bench_with_nothing_wrong_has_no_gap(sound: Campaign) -> None:
    found = diagnose(sound)
    assert found.verdict == "no_gap"
    assert found.effects == []
    assert 0.93 < found.gap.before < 1.08
    assert 0.93 < found.gap.by_test["impact"] < 1.08
    # A block on a resonance that was not fitted asks more of the fit than its own noise; the others must be near 1.
    sines = [value for name, value in found.gap.by_record.items() if name.startswith("sine")]
    assert 0.85 < float(np.median(sines)) < 1.15


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_mass_on_the_bench_is_named_weighed_and_found(massed: Diagnosis) -> None:
    assert massed.verdict == "known"
    assert [f.effect for f in massed.effects] == ["added_mass"]
    only = massed.effects[0]
    assert only.parameters["mass"] == pytest.approx(0.04, rel=0.02)
    assert only.place.x == pytest.approx(0.63, abs=0.01)
    assert massed.gap.before > 20
    assert massed.gap.after < 1.1
