"""Lost samples are distinguished from those that merely stand still, by what the twin expects."""

import numpy as np
import pytest

from modallab.gap.unknown.sample_hold import hold_of
from modallab.gap.unknown.volts import ChannelOperator

NOISE = 3e-4


def channel(kept: float, share: float) -> ChannelOperator:
    rng = np.random.default_rng(4)
    expected, counts = {}, {}
    for k in range(4):
        u = np.sin(2 * np.pi * (0.03 + 0.01 * k) * np.arange(1000)) * 0.5
        read = u + NOISE * rng.standard_normal(1000)
        for i in np.flatnonzero(rng.random(1000) < share):
            read[i] = read[i - 1] if kept else 0.0
        expected[f"r{k}"], counts[f"r{k}"] = u, np.round(read / 1e-4)
    return ChannelOperator(3, {n: c * 1e-4 for n, c in counts.items()}, counts, expected)


@pytest.mark.parametrize("kept", [0.0, 1.0])
def test_the_share_and_what_stands_in_its_place_are_found(kept: float) -> None:
    found = hold_of(channel(kept, 0.06), NOISE)
    assert found is not None
    assert found.kept == kept
    assert found.share == pytest.approx(0.06, abs=0.02)


def test_a_channel_that_loses_nothing_is_left_alone() -> None:
    assert hold_of(channel(1.0, 0.0), NOISE) is None
