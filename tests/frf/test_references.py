"""Several forces at once: the truth is a made-up matrix of FRFs, the noise is known."""

import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.frf.estimate import combine_spectra
from modallab.frf.references import estimate_frf

LINES = 60


def spectra(blocks, inputs=2, outputs=3, *, on_force=0.0, on_response=0.0, seed=0):
    rng = np.random.default_rng(seed)

    def normal(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)

    true = normal(outputs, inputs, LINES) * 1e3
    # The forces hang together, as those of two shakers on one structure do.
    force = np.einsum("ij,bjl->bil", np.eye(inputs) + 0.4, normal(blocks, inputs, LINES))
    response = np.einsum("oil,bil->bol", true, force)
    level = np.sqrt(np.mean(np.abs(response) ** 2, axis=(0, 2)))[:, None]
    force_level = np.sqrt(np.mean(np.abs(force) ** 2, axis=(0, 2)))[:, None]
    return (
        force + on_force * force_level * normal(*force.shape),
        response + on_response * level * normal(*response.shape),
        true,
    )


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
@pytest.mark.parametrize("inputs", [1, 2, 3])
def test_without_noise_all_three_are_the_frf(estimator, inputs):
    force, response, true = spectra(8, inputs)
    found = estimate_frf(force, response, estimator)
    np.testing.assert_allclose(found.frf, true, rtol=1e-6, atol=1e-6 * np.abs(true).max())
    np.testing.assert_allclose(found.coherence, 1)


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
def test_one_force_and_one_response_give_what_they_give_alone(estimator):
    force, response, _ = spectra(5, 1, 1, on_force=0.2, on_response=0.3)
    found = estimate_frf(force, response, estimator)
    alone, coherence = combine_spectra(force[:, 0], response, estimator)
    np.testing.assert_allclose(found.frf[:, 0], alone, rtol=1e-9)
    np.testing.assert_allclose(found.coherence, coherence, atol=1e-12)


def gain(estimator, **noise):
    """Mean of found / true over many blocks: 1 where the estimator has no bias."""
    force, response, true = spectra(500, 2, 2, **noise)
    found = estimate_frf(force, response, estimator).frf
    return np.einsum("oil,oil->", found, true.conj()).real / np.sum(np.abs(true) ** 2)


def test_noise_on_the_responses_biases_h2_up_and_h1_not():
    assert gain("H1", on_response=0.3) == pytest.approx(1, abs=0.01)
    assert gain("H2", on_response=0.3) > 1.03
    assert 1.01 < gain("Hv", on_response=0.3) < gain("H2", on_response=0.3)


def test_noise_on_the_forces_biases_h1_down_and_h2_not():
    assert gain("H1", on_force=0.3) < 0.93
    assert gain("H2", on_force=0.3) == pytest.approx(1, abs=0.015)
    assert gain("H1", on_force=0.3) < gain("Hv", on_force=0.3) < 0.99


@pytest.mark.parametrize("blocks", [3, 20])
def test_circles_hold_the_truth_as_often_as_they_say_however_few_the_blocks(blocks):
    inside = []
    for seed in range(40):
        force, response, true = spectra(blocks, 2, 2, on_response=0.1, seed=seed)
        found = estimate_frf(force, response)
        assert found.freedom == 2 * (blocks - 2)
        inside.append(np.abs(found.frf - true) < found.confidence_radius(0.95))
    assert np.mean(inside) == pytest.approx(0.95, abs=0.012)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f, y: (f[:2], y[:2]), "2 blocks"),
        (lambda f, y: (f * np.nan, y), "NaN"),
        (lambda f, y: (f, y[:, :, :-1]), "belong together"),
        (lambda f, y: (f[:, :1] * np.ones((1, 2, 1)), y), "distinguished from one another"),
        (lambda f, y: (f * 0, y), "are zero"),
        (lambda f, y: (f[..., :0], y[..., :0]), "belong together"),
        (lambda f, y: (f[0], y[0]), "belong together"),
    ],
    ids=["few blocks", "NaN", "lines", "one force twice", "zero", "empty", "axes"],
)
def test_what_gives_no_frf_is_rejected(change, says):
    force, response, _ = spectra(6)
    for estimator in ("H1", "H2", "Hv"):
        with pytest.raises(DataError, match=says):
            estimate_frf(*change(force, response), estimator)


def test_counts_that_cannot_be_are_rejected():
    force, response, _ = spectra(6)
    for averages in (np.nan, 0.0, 2.0, 7.0):
        with pytest.raises(DataError, match="averages"):
            estimate_frf(force, response, averages=averages)
    with pytest.raises(DataError, match="H2 of 2 forces"):
        estimate_frf(force, response[:, :1], "H2")
    for level in (0.0, 1.0, np.nan, 95.0):
        with pytest.raises(DataError, match="probability"):
            estimate_frf(force, response).confidence_radius(level)
