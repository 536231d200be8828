"""Regenerated against measured: for the true model they are the same, block, filter and all."""

import functools

import modal_bench as bench
import numpy as np
import pytest

from modallab.frf.estimate import group_by_point
from modallab.identification.impact import identify_impact
from modallab.identification.options import Options
from modallab.signals.signals import to_signals_of
from modallab.verification.verify import synthesised, verify_frf, verify_impact

BAND = (2.9, 400.0)


@functools.cache
def verified(noise=1e-4, seed=1):
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.impact_blocks(system, rng, points=(5, 3), hits=2, noise=noise, force_noise=noise)
    signals = to_signals_of(blocks, rig)
    model, fit = identify_impact(signals, rig, Options(band_hz=BAND))
    return system, model, verify_impact(model, fit, group_by_point(signals), rig)


def true_mobility(system, frequency_hz, drive):
    s = 2j * np.pi * frequency_hz
    w = 2 * np.pi * system.frequency_hz[:, None]
    return np.einsum(
        "mo,m,mk->ok", system.phi, system.phi[:, drive], s / (s**2 + 2 * system.zeta[:, None] * w * s + w**2)
    )


def test_the_right_model_regenerates_the_blocks_whatever_they_cut_off():
    _, _, found = verified()
    assert found.measured.quantity == found.regenerated.quantity == "mobility"
    assert found.frac.shape == (5, 2)
    assert found.frac.min() > 0.99999


def test_the_measured_mobility_itself_is_not_the_structures():
    system, _, found = verified()
    truth = true_mobility(system, found.measured.frequency_hz, 4)
    cross = np.abs(np.sum(found.measured.values[:, 0].conj() * truth, axis=1)) ** 2
    power = np.sum(np.abs(found.measured.values[:, 0]) ** 2, axis=1) * np.sum(np.abs(truth) ** 2, axis=1)
    assert np.all(cross / power < 0.97)


def test_the_untruncated_model_is_the_structures_own_mobility():
    system, _, found = verified()
    inside = found.untruncated.frequency_hz < 250
    truth = true_mobility(system, found.untruncated.frequency_hz[inside], 4)
    error = np.abs(found.untruncated.values[:, 0, inside] - truth).max()
    assert error < 0.01 * np.abs(truth).max()


def test_noise_lowers_frac():
    assert verified(noise=0.3)[2].frac.min() < verified()[2].frac.min()


def test_an_frf_made_from_the_model_agrees_with_it_inside_its_band():
    _, model, _ = verified()
    frf = synthesised(model, np.linspace(1.0, 450.0, 600), "inertance")
    found = verify_frf(model, frf)
    np.testing.assert_allclose(found.frac, 1, rtol=1e-12)
    assert found.measured.frequency_hz.min() >= model.band_hz[0]
    assert found.measured.frequency_hz.max() <= model.band_hz[1]


@pytest.mark.parametrize(("quantity", "power"), [("mobility", 1), ("inertance", 2)])
def test_a_synthesised_frf_differentiates_the_receptance(quantity, power):
    _, model, _ = verified()
    f = np.linspace(5.0, 100.0, 20)
    expected = synthesised(model, f, "receptance").values * (2j * np.pi * f) ** power
    np.testing.assert_allclose(synthesised(model, f, quantity).values, expected)
