"""Contradictions between rig file and data are reported."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.rig import Rig
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.contradictions import common_frequency_shift


def test_a_common_factor_of_all_frequencies_is_found_even_where_modes_are_missing() -> None:
    model = np.array([4.7, 30.0, 85.0, 165.0, 273.0])
    shift, share = common_frequency_shift(model[[0, 2, 3]] * 0.8, model)
    assert np.exp(shift) == pytest.approx(0.8, rel=2e-3)
    assert share == 1.0


def test_frequencies_of_no_common_factor_agree_with_none() -> None:
    assert common_frequency_shift(np.array([5.0, 9.0, 13.0]), np.array([4.7, 30.0, 85.0, 165.0]))[1] < 0.99


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_beam_of_another_thickness_is_distinguished_from_a_fault(make: Callable[..., Campaign], rig: Rig) -> None:
    campaign = make(tests=("impact",))
    assert rig.beam is not None
    thick = rig.model_copy(update={"beam": rig.beam.model_copy(update={"thickness_m": 1.2 * rig.beam.thickness_m})})
    found = diagnose(Campaign(thick, campaign.blocks), allowed=lambda name: name == "polarity")
    assert found.verdict == "unknown"
    assert any("−16 % off those of the rig file's beam" in note for note in found.notes)


def test_one_hit_alone_makes_no_channel_noisy(make: Callable[..., Campaign]) -> None:
    campaign = make(tests=("impact",))
    assert diagnose(Campaign(campaign.rig, campaign.blocks[:1])).verdict == "no_gap"
