"""Rows that lose samples show it in the records themselves, whatever drives them and however fine the converter is."""

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.gap.conditioning.prepare import channels_losing_samples

NOISE = np.array([3e-4, 3e-4, 3e-4])


def records(share: float, kept: bool, noise_v: float = 3e-4, count_v: float = 3e-4, hz: float = 60.0) -> list[Block]:
    """Five sines, of which row 2 loses a share of its samples."""
    rng = np.random.default_rng(8)
    found = []
    for which in range(5):
        t = np.arange(1024) / 1000.0
        volts = 0.3 * np.sin(2 * np.pi * (hz + which) * t + np.arange(3)[:, None])
        counts = np.round((volts + noise_v * rng.standard_normal(volts.shape)) / count_v)
        for i in np.flatnonzero(rng.random(1024) < share):
            counts[2, i] = counts[2, i - 1] if kept else 0.0
        found.append(
            Block(
                name=f"sine_{which}",
                test="sine",
                order=which,
                rate_hz=1000.0,
                samples=counts.astype(np.int32),
                scale=np.full(3, count_v),
                units=("V", "V", "V"),
                channels=("force", "a01", "a02"),
            )
        )
    return found


@pytest.mark.parametrize(("share", "kept"), [(0.3, False), (0.05, False), (0.3, True), (0.05, True)])
def test_a_row_that_loses_samples_is_found(share: float, kept: bool) -> None:
    assert channels_losing_samples(records(share, kept), NOISE, 0) == (2,)


@pytest.mark.parametrize(("noise_v", "count_v"), [(3e-4, 3e-4), (0.0, 3e-4), (1e-6, 5e-3), (3e-4, 1e-7)])
@pytest.mark.parametrize("hz", [4.0, 60.0, 200.0])
def test_a_signal_that_passes_through_0_loses_nothing(noise_v: float, count_v: float, hz: float) -> None:
    assert channels_losing_samples(records(0.0, kept=False, noise_v=noise_v, count_v=count_v, hz=hz), NOISE, 0) == ()


def test_noise_that_the_losses_make_themselves_hides_them() -> None:
    # Why the caller gives the noise at its calmest: a spectrum takes losses for noise.
    assert channels_losing_samples(records(0.3, kept=False), np.full(3, 0.06), 0) == ()
