"""Two effects on one channel, of which neither shows beside the other, are named together; a channel's curve is not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.diagnosis import diagnose

pytestmark = pytest.mark.thorough("diagnoses a whole campaign")

Make = Callable[..., Campaign]
ON_ONE = {"polarity", "loose_mount", "gain_error", "position_error"}


def on_a_channel(name: str) -> bool:
    """Effects of a channel, and one of the beam: the search for all others takes most of the time."""
    return name in {*ON_ONE, "added_mass"}


def test_a_loose_mount_of_a_sensor_upside_down_is_both(make: Make) -> None:
    campaign = make(
        Effect(effect="polarity", parameters={"sign": -1.0}, place={"channel": 6}),
        Effect(effect="loose_mount", parameters={"hz": 52.0, "zeta": 0.05}, place={"channel": 6}),
        tests=("impact",),
    )
    diagnosis = diagnose(campaign, allowed=on_a_channel)
    assert diagnosis.verdict == "known"
    assert {e.effect for e in diagnosis.effects} == {"polarity", "loose_mount"}
    mount = next(e for e in diagnosis.effects if e.effect == "loose_mount")
    assert mount.parameters["hz"] == pytest.approx(52.0, rel=1e-3)
    assert mount.place.model_dump() == {"channel": 6}


def test_coarse_steps_of_one_channel_are_found_there_and_not_named(make: Make) -> None:
    campaign, row = make(tests=("impact",)), 6
    step = 0.03 * max(float(np.max(np.abs(b.samples[row]))) for b in campaign.blocks)
    blocks = []
    for block in campaign.blocks:
        samples = block.samples.copy()
        samples[row] = np.round(np.round(samples[row] / step) * step)
        blocks.append(replace(block, samples=samples))
    diagnosis = diagnose(Campaign(campaign.rig, tuple(blocks)), allowed=on_a_channel)
    assert diagnosis.verdict == "unknown"
    assert diagnosis.where.channels == [campaign.rig.channels[row].name]
