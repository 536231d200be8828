"""H1, H2 and Hv of one random force, without leakage: which noise bends which of them, and by how much."""

import functools

import numpy as np
import pytest
from scipy import signal

from modallab.core.errors import DataError
from modallab.frf.local_polynomial import frf_of_one_force, local_polynomial_frf

N, RATE = 32768, 512.0
LINES = np.arange(64 * 35, 64 * 100)
POLES = 2 * np.pi * np.array([40.0, 95.0]) * (np.array([-0.01, -0.008]) + 1j)
RESIDUES = np.array([[1.0, 0.7], [0.4, -0.9]])
NOISE = 0.3


@functools.cache
def records(on_force: float, on_response: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Spectra of a record that begins ringing, and the sampled modes' own FRF; noise in each signal's rms."""
    rng = np.random.default_rng(8)
    force = rng.standard_normal(2 * N)
    response = np.zeros((2, 2 * N))
    true = np.zeros((2, LINES.size), complex)
    z = np.exp(-2j * np.pi * LINES / N)
    for pole, residue in zip(POLES, RESIDUES.T, strict=True):
        at = np.exp(pole / RATE)
        response += 2 * np.real(residue[:, None] * signal.lfilter([1.0], [1.0, -at], force))
        true += residue[:, None] * (1 / (1 - at * z) + 1 / (1 - np.conj(at) * z))
    both = np.vstack([force, response])[:, N:]
    share = np.array([on_force, on_response, on_response])[:, None]
    both += share * both.std(axis=1, keepdims=True) * rng.standard_normal(both.shape)
    spectra = np.fft.rfft(both)[None, :, LINES]
    return spectra[:, :1], spectra[:, 1:], true


def gain(estimator: str, on_force: float, on_response: float, least: float = 0.0) -> float:
    """Median of what is found over what is true, on lines where the true is at least such a share of its largest."""
    force, response, true = records(on_force, on_response)
    found, _ = frf_of_one_force(force, response, estimator)
    strong = np.abs(true) >= least * np.abs(true).max(axis=1, keepdims=True)
    return float(np.median((np.abs(found[:, 0]) / np.abs(true))[strong]))


@pytest.mark.thorough("estimates FRFs of many noisy records")
def test_noise_on_the_force_lowers_h1_by_its_power_and_hv_by_half_of_it() -> None:
    power = 1 + NOISE**2
    assert gain("H1", NOISE, 0.0) == pytest.approx(1 / power, abs=0.01)
    assert gain("Hv", NOISE, 0.0) == pytest.approx(power**-0.5, abs=0.01)
    assert gain("H2", NOISE, 0.0) == pytest.approx(1.0, abs=0.01)


@pytest.mark.thorough("fits polynomials to long records once more")
def test_noise_on_the_responses_raises_h2_alone_above_what_is_true() -> None:
    assert gain("H1", 0.0, 0.1, 0.2) == pytest.approx(1.0, abs=0.01)
    assert 1.0 < gain("Hv", 0.0, 0.1, 0.2) < gain("H2", 0.0, 0.1, 0.2)


@pytest.mark.parametrize(
    "estimator", ["H2", pytest.param("Hv", marks=pytest.mark.thorough("fits polynomials to long records once more"))]
)
def test_without_noise_the_record_that_begins_ringing_is_no_trouble(estimator: str) -> None:
    force, response, true = records(0.0, 0.0)
    found, _ = frf_of_one_force(force, response, estimator)
    assert np.linalg.norm(found[:, 0] - true) < 1e-3 * np.linalg.norm(true)


def test_h1_is_that_of_the_local_polynomials() -> None:
    force, response, _ = records(NOISE, 0.1)
    np.testing.assert_array_equal(frf_of_one_force(force, response, "H1")[0], local_polynomial_frf(force, response)[0])


def test_several_forces_have_no_h2_of_this_kind() -> None:
    force, response, _ = records(NOISE, 0.1)
    with pytest.raises(DataError, match="H2 of 2 forces"):
        frf_of_one_force(np.concatenate([force, force], axis=1), response, "H2")
