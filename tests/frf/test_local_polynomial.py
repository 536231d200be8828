"""The truth is the closed form of sampled modes; the records begin and end while they ring."""

import numpy as np
import pytest
from scipy import signal

from modallab.core.errors import DataError
from modallab.frf.estimate import combine_spectra
from modallab.frf.local_polynomial import local_polynomial_frf

N, RATE = 2048, 512.0
POLES = np.array([2 * np.pi * f * (-z + 1j * np.sqrt(1 - z**2)) for f, z in ((40.0, 0.001), (95.0, 0.002))])
RESIDUES = np.array([[[1.0, 0.6], [0.4, -0.8]], [[0.7, -0.5], [-0.9, 0.3]]])
LINES = np.arange(120, 420)


def _records(blocks, inputs, seed=4):
    """Stretches of one long record: every block begins with what rang before it, and ends before it has rung out."""
    rng = np.random.default_rng(seed)
    force = rng.standard_normal((inputs, 8 * N + blocks * N))
    response = np.zeros((2, force.shape[1]))
    for pole, residue in zip(POLES, RESIDUES, strict=True):
        rung = signal.lfilter([1.0], [1.0, -np.exp(pole / RATE)], force)
        response += 2 * np.real(residue[:, :inputs] @ rung)
    cut = [slice(8 * N + k * N, 8 * N + (k + 1) * N) for k in range(blocks)]
    spectra = [np.stack([np.fft.rfft(x[:, c])[:, LINES] for c in cut]) for x in (force, response)]
    z = np.exp(-2j * np.pi * LINES / N)
    true = sum(
        r[..., None] / (1 - np.exp(p / RATE) * z) + r[..., None] / (1 - np.exp(np.conj(p) / RATE) * z)
        for p, r in zip(POLES, RESIDUES[:, :, :inputs], strict=True)
    )
    return spectra[0], spectra[1], true


def _error(found, true):
    return np.sqrt(np.mean(np.abs(found - true) ** 2) / np.mean(np.abs(true) ** 2))


def test_a_ring_down_that_the_block_cuts_off_hardly_bends_it():
    force, response, true = _records(4, 1)
    found, _ = local_polynomial_frf(force, response)
    plain, _ = combine_spectra(force[:, 0], response)
    assert 10 * _error(found, true) < _error(plain[:, None], true)


def test_two_references_at_once_are_distinguished():
    force, response, true = _records(4, 2)
    found, _ = local_polynomial_frf(force, response)
    assert found.shape == (2, 2, LINES.size)
    cross = np.einsum("bol,bil->oil", response, force.conj())
    power = np.einsum("bil,bjl->lij", force, force.conj())
    plain = np.moveaxis(np.moveaxis(cross, -1, 0) @ np.linalg.inv(power), 0, -1)
    assert 10 * _error(found, true) < _error(plain, true)


def test_the_residual_noise_is_the_noise_there_is():
    force, _, _ = _records(4, 1)
    rng = np.random.default_rng(1)
    noise = 3.0 / np.sqrt(2) * (rng.standard_normal((4, 2, LINES.size)) + 1j * rng.standard_normal((4, 2, LINES.size)))
    _, variance = local_polynomial_frf(force, 2.0 * force + noise, order=2, poles=0, half_width=6)
    np.testing.assert_allclose(variance.mean(axis=1), 9.0, rtol=0.15)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f, y: (f[:, 0], y), "belong together"),
        (lambda f, y: (f, y * np.nan), "NaN"),
        (lambda f, y: (f[..., :6], y[..., :6]), "cannot determine"),
        (lambda f, y: (np.concatenate([f, f], axis=1), y), "distinguished from one another"),
        (lambda f, y: (np.ones_like(f), y), "distinguished from one another"),
    ],
    ids=["shape", "nan", "few lines", "the same force twice", "as smooth as the transient"],
)
def test_what_it_cannot_distinguish_is_rejected(change, says):
    force, response, _ = _records(4, 1)
    with pytest.raises(DataError, match=says):
        local_polynomial_frf(*change(force, response))
