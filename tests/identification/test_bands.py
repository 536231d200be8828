"""A wide range with many modes is cut into bands by itself, and gives the modes of the whole."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from test_plscf import frf

from modallab.identification.estimate import estimate_poles
from modallab.identification.start.bands import split_bands

RNG = np.random.default_rng(8)
MANY = 20.0 + 22.0 * np.arange(40) + RNG.uniform(-4, 4, 40)
PHI = RNG.choice([-1.0, 1.0], (40, 4)) * RNG.uniform(0.4, 1.0, (40, 4))
LINES = np.arange(1, 1841) * 0.5


@pytest.fixture(scope="module")
def wide():
    clean = frf(MANY, [0.004] * 40, PHI, [0], LINES, "mobility")
    size = 0.003 * np.sqrt(np.mean(np.abs(clean.values) ** 2, axis=-1, keepdims=True))
    noise = RNG.standard_normal(clean.values.shape) + 1j * RNG.standard_normal(clean.values.shape)
    return replace(clean, values=clean.values + size * noise)


def test_cuts_stand_in_valleys_and_every_mode_belongs_to_one_band(wide):
    bands = split_bands(wide)
    assert len(bands) == 3
    assert bands[0].low_hz == 0
    assert bands[-1].high_hz == np.inf
    poles = 2j * np.pi * MANY
    assert sum(band.own(poles).size for band in bands) == 40
    for below, above in pairwise(bands):
        assert below.high_hz == above.low_hz
        assert below.stop > above.first
        assert np.abs(MANY - below.high_hz).min() > 3


def test_few_modes_are_one_band():
    few = frf(MANY[:4], [0.004] * 4, PHI[:4], [0], LINES, "mobility")
    (band,) = split_bands(few)
    assert (band.first, band.stop) == (0, LINES.size)


@pytest.mark.thorough("identifies forty modes")
def test_forty_modes_are_found_each_once(wide):
    found = np.sort(np.abs(estimate_poles(wide, "plscf").poles)) / (2 * np.pi)
    nearest = found[np.abs(found[:, None] - MANY).argmin(axis=0)]
    np.testing.assert_allclose(nearest, MANY, rtol=1e-4)
    assert np.unique(nearest).size == 40
