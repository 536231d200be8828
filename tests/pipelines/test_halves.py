"""What two measurements of one thing differ by, from the hits of one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.rig import Point
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.frf.estimate import group_by_point
from modallab.gap.modal.halves import share_between_halves
from modallab.pipelines.identify import usable_blocks
from modallab.pipelines.structure_gap import gap_of, model_to_compare
from modallab.signals.signals import Signals

DATA = Path(__file__).parents[1] / "data"
BAND = (500.0, 1500.0)


def campaign() -> Campaign:
    """Five real hits on one structure, of which one sensor at the struck point is known."""
    read = read_campaign(DATA / "hammer_5hits.h5", read_rig(DATA / "hammer_rig.yaml"))
    channels = tuple(c.model_copy(update={"point": 1}) for c in read.rig.channels)
    return replace(read, rig=read.rig.model_copy(update={"points": (Point(id=1, x_m=0.0),), "channels": channels}))


def hits() -> list[Signals]:
    real = campaign()
    (group,) = group_by_point(usable_blocks(real, real.of("impact"))[0])
    return group


def repeated(noise: float) -> list[Signals]:
    """The same hit four times, each with its own noise, over the rms of the response."""
    rng, one = np.random.default_rng(3), hits()[0]
    sigma = noise * float(np.std(one.responses))
    return [replace(one, responses=one.responses + sigma * rng.standard_normal(one.responses.shape)) for _ in range(4)]


def test_halves_of_the_same_hits_differ_by_their_noise_alone() -> None:
    rig = campaign().rig
    assert share_between_halves([[hits()[0]] * 4], rig, BAND) == 0.0
    low, high = (share_between_halves([repeated(noise)], rig, BAND) or 0.0 for noise in (0.01, 0.02))
    assert high == pytest.approx(2 * low, rel=0.02)


def test_one_hit_says_nothing_of_the_next() -> None:
    assert share_between_halves([hits(), hits()[:1]], campaign().rig, BAND) is None


@pytest.mark.thorough("identifies halves of a campaign and compares them")
def test_a_comparison_first_says_by_how_much_its_halves_differ() -> None:
    real = campaign()
    found = gap_of(real, model_to_compare(real, BAND), before=real, band_hz=BAND).diagnosis
    assert found.verdict == "no_gap"
    assert found.notes[0].startswith("The two halves of the bench's hits differ by ")
