"""When a diagnosis looks for effects that must be stepped in time."""

from collections.abc import Callable

import numpy as np
import pytest
import twin_campaign
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.report.harmonics import channels_out_of_proportion

DRAG = Effect(effect="air_drag", parameters={"c2_total": 60.0}, place={"x": "all"})
CRACK = Effect(effect="breathing_crack", parameters={"EI_loss_open": 0.8}, place={"x": 0.2})


def saturated(volts: NDArray[np.float64], block: Block) -> NDArray[np.float64]:
    volts = volts.copy()
    volts[4] -= 0.2 * volts[4] ** 3 / np.max(np.abs(volts[4])) ** 2
    return volts


def distorted(volts: NDArray[np.float64], block: Block) -> NDArray[np.float64]:
    return volts - 0.2 * volts**3 / np.max(np.abs(volts), axis=1, keepdims=True) ** 2


@pytest.mark.parametrize(("effects", "overtones"), [((DRAG,), "odd"), ((CRACK,), "even"), ((), None)])
def test_overtones_say_whether_a_beam_answers_alike_both_ways(
    make: Callable[..., Campaign], effects: tuple[Effect, ...], overtones: str | None
) -> None:
    assert channels_out_of_proportion(prepare_campaign(make(*effects, tests=("sine",)))) == overtones


@pytest.mark.parametrize(("effects", "overtones"), [((DRAG,), "odd"), ((CRACK,), "even"), ((), None)])
def test_they_do_so_for_sines_between_the_lines_as_well(
    make: Callable[..., Campaign], monkeypatch: pytest.MonkeyPatch, effects: tuple[Effect, ...], overtones: str | None
) -> None:
    monkeypatch.setattr(twin_campaign, "LINES", [line + 0.37 for line in twin_campaign.LINES])
    assert channels_out_of_proportion(prepare_campaign(make(*effects, tests=("sine",)))) == overtones


@pytest.mark.parametrize("spoil", [saturated, distorted])
def test_a_channel_that_saturates_or_a_force_that_is_distorted_does_not(
    make: Callable[..., Campaign], spoil: Callable[..., NDArray[np.float64]]
) -> None:
    assert channels_out_of_proportion(prepare_campaign(make(spoil=spoil, tests=("sine",)))) is None
