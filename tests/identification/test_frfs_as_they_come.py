"""FRFs of other programs: coherence weighs the lines, a window's damping is taken off, and clear modes are found."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Rig
from modallab.identification.frf_model import identify_frf, identify_given_frf
from modallab.identification.likelihood.frf_fit import fit_frf, line_weights
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.lost_modes import restore_lost_modes, unshared_power
from modallab.identification.selection.prune import is_mode
from modallab.identification.start.stabilisation import OrderPoles
from modallab.verification.verify import verify_frf

PHI = np.array([[1.0, 0.5, -0.7], [0.8, -1.0, 0.3], [0.9, 0.4, 1.1]])
LINES = np.arange(20.0, 200.0, 0.25)
AVERAGES = 20


def rig_of(frf):
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=i, name=n, quantity="acceleration", unit="m/s^2") for i, n in enumerate(frf.outputs, 1)]
    return Rig(name="any", model="unknown", channels=tuple(channels))


def viscous(f_hz, zeta, lines=LINES, shift=0.0):
    """Mobilities (outputs, 1, lines), in closed form."""
    s, w = shift + 2j * np.pi * lines, 2 * np.pi * np.array(f_hz)[:, None]
    per_mode = s / (s**2 + 2 * np.array(zeta)[:, None] * w * s + w**2)
    phi = PHI[: len(f_hz)]
    return Frf(lines, np.einsum("mo,m,ml->ol", phi, phi[:, 0], per_mode)[:, None], "mobility", *NAMES)


NAMES = ("a0", "a1", "a2"), (None,) * 3, (None,)


def hysteretic(f_hz, eta):
    s, w = 2j * np.pi * LINES, 2 * np.pi * np.array(f_hz)[:, None]
    per_mode = s / (s**2 + w**2 * (1 + 1j * np.array(eta)[:, None]))
    phi = PHI[: len(f_hz)]
    return Frf(LINES, np.einsum("mo,m,ml->ol", phi, phi[:, 0], per_mode)[:, None], "mobility", *NAMES)


def noisy(frf, level, seed=0):
    """With noise of this share of the level at each line (lines,) or everywhere."""
    rng = np.random.default_rng(seed)
    sigma = np.broadcast_to(level * np.sqrt(np.mean(np.abs(frf.values) ** 2)), frf.frequency_hz.shape)
    unit = rng.normal(size=frf.values.shape) + 1j * rng.normal(size=frf.values.shape)
    return replace(frf, values=frf.values + sigma / np.sqrt(2) * unit), sigma**2


@functools.cache
def with_hum(seed):
    """FRFs that hum spoils beside a resonance, and their coherence."""
    level = np.where(np.abs(LINES - 50) < 3, 0.3, 1e-3)
    clean = viscous([49.0, 120.0], [0.01, 0.01])
    frf, variance = noisy(clean, level, seed)
    relative = AVERAGES * variance / np.abs(clean.values) ** 2
    return replace(frf, coherence=1 / (1 + relative), averages=(AVERAGES,))


@pytest.mark.thorough("identifies many recordings")
def test_imported_coherence_weighs_the_lines():
    weighed = [identify_frf(with_hum(k), rig_of(with_hum(k)), IdentificationOptions())[0] for k in range(3)]
    plain = [
        identify_frf(replace(with_hum(k), coherence=None), rig_of(with_hum(k)), IdentificationOptions())[0]
        for k in range(3)
    ]
    off = [np.abs(m.frequency_hz - [49.0, 120.0]).mean() for m in weighed]
    off_plain = [np.abs(m.frequency_hz[[0, -1]] - [49.0, 120.0]).mean() for m in plain]
    assert np.mean(off) < 0.2 * np.mean(off_plain)
    for m in weighed:
        assert np.all(np.abs(m.frequency_hz - [49.0, 120.0]) < 4 * m.frequency_sigma_hz)
        assert np.all(np.abs(m.damping_ratio - 0.01) < 4 * m.damping_sigma)


def test_weights_follow_the_variance_and_coherence_of_one_average_says_nothing():
    frf = with_hum(0)
    weight = line_weights(frf)
    spoilt = np.abs(LINES - 50) < 2
    assert np.mean(weight**2) == pytest.approx(1)
    assert weight[spoilt].max() < 0.05 * np.median(weight[LINES > 60])
    assert line_weights(replace(frf, coherence=np.ones_like(frf.coherence))) is None
    assert line_weights(replace(frf, coherence=None)) is None


@pytest.mark.parametrize("method", ["plscf", "peak", "circle"])
def test_the_damping_of_an_exponential_window_is_taken_off(method):
    """tau = 0.5 s adds 1 / (tau omega): 0.64 % at 49 Hz, which is more than the mode has."""
    frf, _ = noisy(viscous([49.0, 120.0], [0.005, 0.004], shift=2.0), 1e-4)
    frf = replace(frf, damping_shift=2.0)
    options = IdentificationOptions(method=method)
    model = options.own_model(frf, None) if options.own_model else identify_frf(frf, rig_of(frf), options)[0]
    exact = method == "plscf"
    np.testing.assert_allclose(model.damping_ratio, [0.005, 0.004], rtol=2e-3 if exact else 0.3)
    if exact:
        assert any("0.65 % at 49 Hz" in note for note in model.notes)
        assert verify_frf(model, frf).frac.min() > 0.9999


@pytest.mark.parametrize(("half_width", "step"), [(2.0, 0.5), (4.0, 1.0), (2.0, 0.25)])
def test_a_clear_mode_alone_in_a_narrow_band_is_found(half_width, step):
    lines = np.arange(100 - half_width, 100 + half_width + 1e-9, step)
    frf, _ = noisy(viscous([40.0, 100.0, 180.0], [0.005] * 3, lines), 1e-3)
    model, _ = identify_frf(frf, rig_of(frf), IdentificationOptions())
    np.testing.assert_allclose(model.frequency_hz, [100.0], rtol=1e-4)
    np.testing.assert_allclose(model.damping_ratio, [0.005], rtol=0.02)


@pytest.mark.parametrize(("f_hz", "eta"), [((50, 120), (0.2, 0.2)), ((50, 120), (0.3, 0.3)), ((50, 54), (0.1, 0.1))])
def test_both_modes_with_hysteretic_damping_are_found(f_hz, eta):
    frf, _ = noisy(hysteretic(f_hz, eta), 1e-4)
    model, _ = identify_frf(frf, rig_of(frf), IdentificationOptions())
    assert model.n_modes == 2
    np.testing.assert_allclose(model.frequency_hz, f_hz, rtol=0.03)
    np.testing.assert_allclose(model.damping_ratio, np.array(eta) / 2, rtol=0.08)


def test_a_mode_that_the_search_has_lost_comes_back_and_noise_does_not():
    frf, _ = noisy(viscous([49.0, 120.0, 121.5], [0.01] * 3), 1e-4)
    w = 2 * np.pi * np.array([49.0, 120.0])
    fit = fit_frf(frf, (-0.01 + 1j) * w)
    there = (-0.01 + 1j) * 2 * np.pi * np.array([49.0, 120.0, 121.51, 170.0])
    orders = [OrderPoles(n, there) for n in range(2, 12)]
    found, keep, notes = restore_lost_modes(frf, fit, is_mode(fit, (20.0, 200.0)), orders, (20.0, 200.0))
    got = np.sort(found.point.parameters.omega[keep]) / (2 * np.pi)
    np.testing.assert_allclose(got, [49.0, 120.0, 121.5], rtol=1e-4)
    assert notes == ()
    assert np.all(unshared_power(found)[keep] > 0.9)


@pytest.mark.parametrize("order", [30, 60, 90, 120])
def test_a_weak_mode_is_found_whatever_the_order(order):
    frf = viscous([49.0, 120.0], [0.01, 0.01])
    s, w = 2j * np.pi * LINES, 2 * np.pi * 85.0
    weak = 3e-4 * s / (s**2 + 2 * 0.004 * w * s + w**2)
    frf, _ = noisy(replace(frf, values=frf.values + weak * np.array([1.0, -0.6, 0.8])[:, None, None]), 1e-4)
    model, _ = identify_frf(frf, rig_of(frf), IdentificationOptions(max_order=order))
    np.testing.assert_allclose(model.frequency_hz, [49.0, 85.0, 120.0], rtol=1e-3)


def test_conjugates_are_named_as_such():
    frf, _ = noisy(viscous([49.0, 120.0], [0.01, 0.01]), 1e-3)
    assert identify_given_frf(frf, rig_of(frf), IdentificationOptions())[0].n_modes == 2
    with pytest.raises(IdentificationError, match="complex conjugates"):
        identify_given_frf(replace(frf, values=frf.values.conj()), rig_of(frf), IdentificationOptions())
