"""Hits under mains hum while the beam still rings: the phase of the one is not read from the other."""

import numpy as np
import pytest
from twin_campaign import LENGTH, bench, built, link

from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.diagnosis import diagnose
from modallab.twin.predict import predict_hit

VOLTS_PER_ACC = 0.01


def ringing(rig: Rig, point: int) -> np.ndarray:
    """(accelerometers, 2048) V that a hit of 40 N two seconds before leaves at 2 kHz."""
    force = np.zeros(6144)
    force[100:109] = 40 * np.hanning(9)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    rows = tuple(c.index for c in rig.responses)
    return predict_hit(bench(rig, ()), force, 2000.0, LENGTH * point / 10, rows, x, 0.0)[:, 4096:] * VOLTS_PER_ACC


def spoiled(volts: float, rings: bool = True) -> Campaign:
    rig, rng = link(), np.random.default_rng(7)
    row = volts * (0.5 + 0.1 * np.arange(11))[:, None]

    def spoil(read: np.ndarray, block: Block) -> np.ndarray:
        t = np.arange(read.shape[1]) / block.rate_hz
        if rings and block.test == "impact":
            read[1:] += ringing(rig, block.drive_point or 0)
        return read + row * np.cos(2 * np.pi * 60.0 * t + rng.uniform(0, 6))

    return built(rig, spoil=spoil)


@pytest.mark.parametrize("volts", [0.06, pytest.param(0.5, marks=pytest.mark.thorough("diagnoses a whole campaign"))])
def test_both_are_named_and_taken_out(volts: float) -> None:
    found = diagnose(spoiled(volts))
    assert {f.effect for f in found.effects} == {"mains_hum", "residual_ringing"}
    assert found.verdict == "known"
    assert found.gap.after < 1.3


def test_hits_that_hum_hides_are_used() -> None:
    # 0.25 V of hum are 12 N on the force, of a hit of 60 N: nothing of it stands ten deviations above the rest.
    campaign = spoiled(0.5, rings=False)
    prepared = prepare_campaign(campaign)
    assert [b.name for b in prepared.blocks] == [b.name for b in campaign.blocks]
    assert not any("excluded" in note for note in prepared.notes)
