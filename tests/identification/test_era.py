from dataclasses import replace

import numpy as np
import pytest
from test_plscf import frf

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.estimators.era import era
from modallab.identification.start.stabilisation import stable_poles

FREQUENCY, ZETA = np.array([12.0, 40.0, 41.0, 90.0]), np.array([0.01, 0.005, 0.008, 0.004])
PHI = np.random.default_rng(0).standard_normal((4, 6))
LINES = np.arange(1, 2049) * 0.0625


def sampled(seed=None):
    """FRF of sampled decays: what a DFT of the structure's own impulse response gives, without leakage of any kind."""
    w = 2 * np.pi * FREQUENCY
    poles = -ZETA * w + 1j * w * np.sqrt(1 - ZETA**2)
    n = 4096
    dt = 1 / (2 * LINES[-1])
    t = np.arange(n) * dt
    residue = PHI[:, :, None] * PHI[:, None, [0, 3]]
    decay = np.exp(poles[:, None] * t)
    impulse = np.einsum("roi,rt->oit", residue, decay.imag / poles.imag[:, None])
    impulse += 0 if seed is None else 1e-3 * impulse.std() * np.random.default_rng(seed).standard_normal(impulse.shape)
    values = np.fft.rfft(impulse)[..., 1:]
    return replace(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES), values=values)


def test_sampled_decays_give_their_own_poles():
    last = era(sampled(), 8)[-1]
    np.testing.assert_allclose(np.abs(last.poles), 2 * np.pi * FREQUENCY, rtol=1e-4)
    np.testing.assert_allclose(-last.poles.real / np.abs(last.poles), ZETA, rtol=0.02)


def test_in_little_noise_the_modes_hold_over_the_orders():
    found = stable_poles(era(sampled(1), 30))
    assert {12, 40, 41, 90} <= {round(abs(p.pole) / (2 * np.pi)) for p in found}


def test_lines_off_their_own_grid_and_bad_values_are_rejected():
    good = sampled()
    with pytest.raises(DataError, match="multiples"):
        era(replace(good, frequency_hz=good.frequency_hz + 0.03), 8)
    with pytest.raises(DataError, match="NaN"):
        era(replace(good, values=good.values * np.nan), 8)
    with pytest.raises(DataError, match="phase"):
        era(replace(good, values=np.abs(good.values) + 0j), 8)


def test_too_high_an_order_is_rejected():
    few = replace(sampled(), frequency_hz=LINES[:30], values=sampled().values[..., :30])
    with pytest.raises(IdentificationError, match="samples of impulse response"):
        era(few, 200)
