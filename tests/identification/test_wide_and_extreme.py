"""Modes stay right where identification is hard: many in a wide range, hardly damped, damped a lot, on one another."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest
from test_plscf import frf

from modallab.identification.frf_model import identify_frf
from modallab.identification.impact import identify_impact
from modallab.identification.options import IdentificationOptions
from modallab.identification.start.bands import split_bands
from modallab.signals.signals import to_signals_of

POINTS = 4


def noisy(clean, share, seed=5):
    rng = np.random.default_rng(seed)
    size = share * np.sqrt(np.mean(np.abs(clean.values) ** 2, axis=-1, keepdims=True) / 2)
    noise = rng.standard_normal(clean.values.shape) + 1j * rng.standard_normal(clean.values.shape)
    named = replace(
        clean,
        output_points=tuple(range(1, clean.values.shape[0] + 1)),
        input_points=tuple(range(1, clean.values.shape[1] + 1)),
    )
    return replace(named, values=clean.values + size * noise)


def shapes(modes, points=POINTS, seed=1):
    rng = np.random.default_rng(seed)
    return rng.choice([-1.0, 1.0], (modes, points)) * rng.uniform(0.4, 1.0, (modes, points))


@pytest.mark.thorough("identifies a wide band twice")
def test_bands_and_one_band_give_the_same_modes_within_sigma():
    modes = 26
    truth_hz = 20.0 + 22.0 * np.arange(modes) + np.random.default_rng(8).uniform(-4, 4, modes)
    wide = noisy(frf(truth_hz, [0.004] * modes, shapes(modes), [0], np.arange(1, 1221) * 0.5, "mobility"), 0.003)
    assert len(split_bands(wide)) > 1
    split, _ = identify_frf(wide, bench.rig(POINTS), IdentificationOptions())
    whole, _ = identify_frf(wide, bench.rig(POINTS), IdentificationOptions(max_order=120))
    assert split.n_modes == whole.n_modes == modes
    for one in (split, whole):
        assert np.abs((one.frequency_hz - truth_hz) / one.frequency_sigma_hz).max() < 4
    # Both are the maximum of one likelihood: they differ by where the search was ended, a tenth of sigma.
    assert np.all(np.abs(split.frequency_hz - whole.frequency_hz) < 0.3 * whole.frequency_sigma_hz)
    assert np.all(np.abs(split.damping_ratio - whole.damping_ratio) < 0.3 * whole.damping_sigma)


@pytest.mark.parametrize("zeta", [1e-4, 0.1])
def test_one_mode_hardly_or_heavily_damped_among_others(zeta):
    truth_hz, truth_zeta = np.array([12.0, 25.03, 41.0]), np.array([0.005, zeta, 0.004])
    clean = frf(truth_hz, truth_zeta, shapes(3), [0], np.arange(20, 1200) * 0.05, "mobility")
    model, _ = identify_frf(noisy(clean, 0.005), bench.rig(POINTS), IdentificationOptions())
    assert model.n_modes == 3
    assert np.abs((model.frequency_hz - truth_hz) / model.frequency_sigma_hz).max() < 4
    assert np.abs((model.damping_ratio - truth_zeta) / model.damping_sigma).max() < 4
    np.testing.assert_allclose(model.damping_ratio, truth_zeta, rtol=0.05)


@pytest.mark.parametrize("zeta", [1e-4, 0.1])
def test_hits_on_a_structure_hardly_or_heavily_damped(zeta):
    rng = np.random.default_rng(2)
    system = bench.modes(rng)
    system = bench.Modes(system.frequency_hz, np.array([0.005, zeta, 0.004]), system.phi)
    rig = bench.rig(5)
    signals = to_signals_of(bench.impact_blocks(system, rng, hits=3, noise=0.01), rig)
    model, _ = identify_impact(signals, rig, IdentificationOptions(band_hz=(3.0, 1.3 * float(system.frequency_hz[2]))))
    assert model.n_modes == 3
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz, rtol=2e-3)
    assert np.abs((model.damping_ratio - system.zeta) / model.damping_sigma).max() < 4.5


@pytest.mark.parametrize("references", [2, 3])
def test_repeated_roots_are_as_many_modes_as_references_can_distinguish(references):
    """As many modes on one pole as there are forces, and a force more than modes."""
    for modes in {2, references}:
        truth_hz = [30.0, *[60.0] * modes, 95.0]
        zeta = [0.006, *[0.005] * modes, 0.004]
        phi = np.random.default_rng(3).standard_normal((len(zeta), 8))
        clean = frf(truth_hz, zeta, phi, list(range(references)), np.arange(1, 481) * 0.25, "mobility")
        model, _ = identify_frf(noisy(clean, 0.002), bench.rig(8), IdentificationOptions())
        assert model.n_modes == modes + 2
        np.testing.assert_allclose(model.frequency_hz, truth_hz, rtol=2e-4)
        np.testing.assert_allclose(model.damping_ratio, zeta, rtol=0.02)
        plane, _ = np.linalg.qr(phi[1:-1].T)
        inside = plane @ (plane.T @ model.shapes[1:-1].T)
        np.testing.assert_allclose(
            np.linalg.norm(inside, axis=0), np.linalg.norm(model.shapes[1:-1], axis=1), rtol=2e-3
        )


def test_fewer_references_than_repeated_roots_see_as_many_as_they_are():
    phi = np.random.default_rng(3).standard_normal((5, 8))
    clean = frf([30.0, 60.0, 60.0, 60.0, 95.0], [0.005] * 5, phi, [0, 1], np.arange(1, 481) * 0.25, "mobility")
    model, _ = identify_frf(noisy(clean, 0.002), bench.rig(8), IdentificationOptions())
    assert model.n_modes == 4
