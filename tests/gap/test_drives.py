"""Records of a broadband drive: reduced to what the force answers, whatever the force was and what rang before it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from twin_campaign import bench, drive, link

from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.core.errors import DataError
from modallab.core.hold_out import MIXED
from modallab.core.units import Broadband
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.conditioning.records import split_held_out
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.initial_gap import weights_of
from modallab.gap.report.measure import squared_residuals

RIG = link()
MASS = Effect(effect="added_mass", parameters={"mass": 0.03}, place={"x": 0.8})


@cache
def sound(test: Broadband) -> PreparedCampaign:
    return prepare_campaign(Campaign(RIG, tuple(driven(test))))


def driven(test: Broadband, *effects: Effect, seed: int = 1) -> Sequence[Block]:
    return drive(RIG, bench(RIG, effects), test, np.random.default_rng(seed))


@pytest.mark.parametrize("test", ["chirp", pytest.param("random", marks=pytest.mark.thorough("makes a long FRF"))])
def test_the_true_twin_leaves_noise_alone(test: Broadband) -> None:
    """The records begin from rest, so that modes decay beside what the drive makes."""
    prepared = sound(test)
    data = reduce_blocks(prepared.campaign, prepared.blocks, weights_of(prepared))
    assert squared_residuals(bench(RIG, ()), data).gap == pytest.approx(1.0, abs=0.05)


def test_a_force_that_is_only_noise_is_rejected() -> None:
    rows = [c.index for c in RIG.responses]
    unforced = [replace(b, samples=np.where(np.isin(range(11), rows)[:, None], b.samples, 0)) for b in driven("chirp")]
    with pytest.raises(DataError):
        diagnose(Campaign(RIG, tuple(unforced)))


def test_a_third_of_each_drive_is_held_out() -> None:
    fitted, held = split_held_out(sound("chirp").blocks, MIXED)
    assert sum(b.n_samples for b in held) * 2 == sum(b.n_samples for b in fitted)


@pytest.mark.thorough("diagnoses two campaigns")
def test_a_mass_is_found_under_a_chirp_and_none_without() -> None:
    assert diagnose(Campaign(RIG, tuple(driven("chirp")))).verdict == "no_gap"
    found = diagnose(Campaign(RIG, tuple(driven("chirp", MASS))))
    assert [f.effect for f in found.effects] == ["added_mass"]
    low, high = found.effects[0].interval["mass"]
    assert low < 0.03 < high
