"""Noise of rows that are not alike, and what of it rises to low frequencies."""

from dataclasses import replace

import numpy as np
import pytest
from twin_campaign import built, link

from modallab.core.block import Block
from modallab.gap.conditioning.noise import low_frequency_noise_power, measured_row_noise, noise_of_rig_file
from modallab.gap.conditioning.records import records_in_volts, usable_records

WHITE = 3e-4 * np.linspace(0.7, 1.6, 11)


def noisy(rising_v2: float, seed: int = 2) -> tuple[Block, ...]:
    rng = np.random.default_rng(seed)

    def spoil(volts: np.ndarray, block: Block) -> np.ndarray:
        n = volts.shape[1]
        hz = np.maximum(np.fft.rfftfreq(n, 1 / block.rate_hz), 0.5)
        more = np.sqrt(WHITE[:, None] ** 2 + rising_v2 / hz)
        white = np.fft.rfft(rng.standard_normal(volts.shape), axis=1)
        return volts + np.fft.irfft(white * more, n, axis=1)

    rig = link()
    blocks = usable_records(records_in_volts(built(rig, spoil=spoil)))
    return tuple(replace(b) for b in blocks)


def test_each_row_has_its_own_noise() -> None:
    blocks = noisy(0.0)
    rig = link()
    found = measured_row_noise(blocks, noise_of_rig_file(rig, blocks), rig.force_channel.index)
    # The bench's own noise and the converter's rounding are there too.
    assert found == pytest.approx(np.sqrt(WHITE**2 + 3e-4**2 + (10 / 32768) ** 2 / 12), rel=0.12)


@pytest.mark.parametrize("rising_v2", [0.0, 1.2e-6])
def test_noise_that_rises_is_distinguished_from_white_noise(rising_v2: float) -> None:
    blocks = noisy(rising_v2)
    rig = link()
    own = measured_row_noise(blocks, noise_of_rig_file(rig, blocks), rig.force_channel.index)
    assert low_frequency_noise_power(blocks, own) == pytest.approx(rising_v2, rel=0.35, abs=1e-9)
