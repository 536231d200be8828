"""Whether records agree with the simulation: from one hit on, by the channels that differ."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.core.errors import DataError
from modallab.gap.inference.agreement import Agreement, agreement, records_of_last_setting


def of_first_hit(campaign) -> Agreement:
    hits = [b for b in campaign.blocks if b.test == "impact"]
    return agreement(replace(campaign, blocks=tuple(hits[:1])))


def test_a_sound_bench_agrees_after_one_hit(make) -> None:
    found = of_first_hit(make())
    assert not found.differing
    assert not found.modes_differ
    assert found.agrees
    assert found.sentence.startswith("The simulation agrees with all 10 channels within 2 %")


@pytest.mark.parametrize(
    ("effect", "parameters"),
    [
        ("gain_error", {"gain": 0.7}),
        ("polarity", {"sign": -1.0}),
        ("position_error", {"dx": 0.05}),
        ("loose_mount", {"hz": 120.0, "zeta": 0.05}),
    ],
)
def test_one_hit_shows_which_sensor_is_wrong(make, effect, parameters) -> None:
    found = of_first_hit(make(Effect(effect=effect, parameters=parameters, place={"channel": 6})))
    assert [name[-2:] for name in found.differing] == ["06"]
    assert not found.modes_differ
    assert found.differing[0] in found.sentence


def test_the_share_of_a_wrong_sensitivity_is_its_error(make) -> None:
    found = of_first_hit(make(Effect(effect="gain_error", parameters={"gain": 0.7}, place={"channel": 6})))
    # Measured is 0.7 of predicted: the difference is 0.43 of what is measured; scales stand a factor of 1.8 apart.
    assert 0.43 / 1.8 < found.channels[found.differing[0]] < 0.43 * 1.8


def test_a_soft_clamp_shows_in_the_modes(make) -> None:
    found = of_first_hit(make(Effect(effect="clamp_rotation", parameters={"k_rot": 2000.0}, place={"x": 0.0})))
    assert found.modes_differ
    assert "clamp" in found.sentence


def test_a_wrong_force_sensitivity_shows_on_all_channels(make) -> None:
    found = of_first_hit(make(Effect(effect="force_gain", parameters={"gain": 0.7}, place={"channel": 0})))
    assert len(found.differing) == 10
    assert "force sensor" in found.sentence


def test_sines_alone_are_compared_too(make) -> None:
    campaign = make(Effect(effect="polarity", parameters={"sign": -1.0}, place={"channel": 3}))
    sines = tuple(b for b in campaign.blocks if b.test == "sine")
    found = agreement(replace(campaign, blocks=sines))
    assert found.frequencies is None
    assert [name[-2:] for name in found.differing] == ["03"]
    # A sensor upside down differs by all of its response and more: no exponent.
    assert f"{found.differing[0]} (100 %)" in found.sentence


def test_the_latest_records_are_those_of_the_last_point(make) -> None:
    campaign = make()
    hits = [b for b in campaign.blocks if b.test == "impact"]
    kept = records_of_last_setting(replace(campaign, blocks=tuple(hits))).blocks
    assert {b.drive_point for b in kept} == {hits[-1].drive_point}
    assert kept[-1] is hits[-1]


def test_a_record_without_motion_is_no_agreement(make) -> None:
    campaign = make()
    hit = next(b for b in campaign.blocks if b.test == "impact")
    with pytest.raises(DataError):
        agreement(replace(campaign, blocks=(replace(hit, samples=np.zeros_like(hit.samples)),)))
