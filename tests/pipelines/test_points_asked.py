"""Points that a comparison needs are asked for before anything is identified."""

from pathlib import Path

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.pipelines.structure_gap import gap_against

LINES = np.arange(10, 95, 0.125)


def campaign(point: int | None, *, noise: bool = False) -> Campaign:
    """A mode at 40 Hz, or noise, on a rig with points or without."""
    placed = () if point is None else (Point(id=1, x_m=0.0),)
    force = Channel(index=0, name="force", quantity="force", unit="N", point=point)
    sensor = Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=point)
    rig = Rig(name="one sensor", model="unknown", points=placed, channels=(force, sensor))
    w, w0, rng = 2 * np.pi * LINES, 2 * np.pi * 40.0, np.random.default_rng(1)
    values = 1e-3 * (rng.normal(size=(1, 1, LINES.size, 2)) @ [1, 1j])
    values = values if noise else values - (w**2) / (w0**2 - w**2 + 0.02j * w0 * w)
    return Campaign(rig, (), (Frf(LINES, values, "inertance", ("a1",), (point,), (point,)),), source="one.h5")


def test_points_that_lack_are_named_before_the_search_for_modes(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no point is known of channel a1, the force") as caught:
        gap_against(campaign(None, noise=True), tmp_path / "never_read.h5")
    assert "--rig" in caught.value.remedy


def test_a_reference_without_points_takes_those_of_the_rig_that_is_given(tmp_path: Path) -> None:
    write_campaign(campaign(None), tmp_path / "before.h5")
    assert gap_against(campaign(1), tmp_path / "before.h5").diagnosis.verdict == "no_gap"
