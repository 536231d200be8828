"""An effect far below the sizes that a search begins with is named, on a beam at the end of its tolerances."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.diagnosis import diagnose

pytestmark = pytest.mark.thorough("diagnoses a whole campaign")

COMPARED = {"gain_error", "position_error", "loose_mount", "thermal_drift", "added_mass"}
STIFF_PA = 2.14e11
"""Young's modulus as believed: the bench's is three standard deviations lower."""


@pytest.mark.parametrize(
    ("effect", "number", "value", "within"),
    [("gain_error", "gain", 1.006, 1e-3), ("position_error", "dx", 0.0004, 4e-5)],
)
def test_a_small_effect_on_one_channel_is_named(
    make: Callable[..., Campaign], effect: str, number: str, value: float, within: float
) -> None:
    campaign = make(Effect(effect=effect, parameters={number: value}, place={"channel": 5}))
    assert campaign.rig.beam is not None
    beam = campaign.rig.beam.model_copy(update={"youngs_modulus_pa": STIFF_PA})
    believed = campaign.rig.model_copy(update={"beam": beam})
    diagnosis = diagnose(replace(campaign, rig=believed), allowed=COMPARED.__contains__)
    assert [e.effect for e in diagnosis.effects] == [effect]
    assert diagnosis.effects[0].place.model_dump() == {"channel": 5}
    assert diagnosis.effects[0].parameters[number] == pytest.approx(value, abs=within)
