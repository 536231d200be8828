"""FRF estimators against closed forms, and the exponential window's exact correction."""

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.frf.estimate import combine_spectra, convert_frf, impact_frf, lines_of_band
from modallab.signals.signals import to_signals_of

BLOCKS, LINES = 4000, 3
TRUE = np.array([2.0 - 1.0j, -0.5 + 0.2j, 3.0j])


def noisy(force_noise=0.0, response_noise=0.0, seed=1):
    rng = np.random.default_rng(seed)

    def white(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) / np.sqrt(2)

    force = white(BLOCKS, LINES)
    response = (TRUE * force + response_noise * white(BLOCKS, LINES))[:, None]
    return force + force_noise * white(BLOCKS, LINES), response


def test_without_noise_all_three_are_the_frf_and_coherence_is_one():
    for estimator in ("H1", "H2", "Hv"):
        found, coherence = combine_spectra(*noisy(), estimator)
        np.testing.assert_allclose(found[0], TRUE, rtol=1e-12)
        np.testing.assert_allclose(coherence, 1, rtol=1e-12)


def test_h1_is_unbiased_under_response_noise_and_h2_reads_high_by_the_noise_power():
    noise = 0.5
    ratio = 1 + noise**2 / np.abs(TRUE) ** 2
    h1, coherence = combine_spectra(*noisy(response_noise=noise), "H1")
    h2, _ = combine_spectra(*noisy(response_noise=noise), "H2")
    hv, _ = combine_spectra(*noisy(response_noise=noise), "Hv")
    np.testing.assert_allclose(np.abs(h1[0]), np.abs(TRUE), rtol=0.03)
    np.testing.assert_allclose(np.abs(h2[0]), np.abs(TRUE) * ratio, rtol=0.06)
    np.testing.assert_allclose(np.abs(hv[0]), np.abs(TRUE) * np.sqrt(ratio), rtol=0.05)
    np.testing.assert_allclose(coherence[0], 1 / ratio, rtol=0.06)


def test_h2_is_unbiased_under_force_noise_and_h1_reads_low():
    noise = 0.5
    h1, coherence = combine_spectra(*noisy(force_noise=noise), "H1")
    h2, _ = combine_spectra(*noisy(force_noise=noise), "H2")
    np.testing.assert_allclose(np.abs(h1[0]), np.abs(TRUE) / (1 + noise**2), rtol=0.05)
    np.testing.assert_allclose(np.abs(h2[0]), np.abs(TRUE), rtol=0.05)
    np.testing.assert_allclose(coherence[0], 1 / (1 + noise**2), rtol=0.05)


def test_estimators_are_ordered_and_share_their_phase():
    h1, h2, hv = (combine_spectra(*noisy(0.3, 0.3), e)[0] for e in ("H1", "H2", "Hv"))
    assert np.all(np.abs(h1) <= np.abs(hv))
    assert np.all(np.abs(hv) <= np.abs(h2))
    np.testing.assert_allclose(np.angle(h1), np.angle(h2), atol=1e-12)


def test_one_block_is_coherent_by_construction():
    force, response = noisy(0.3, 0.3)
    np.testing.assert_allclose(combine_spectra(force[:1], response[:1])[1], 1)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda f, y: (f * np.where(np.arange(LINES) == 1, 0, 1), y), "no content"),
        (lambda f, y: (f, y * np.nan), "NaN"),
        (lambda f, y: (f.T, y), "do not belong"),
        (lambda f, y: (f, y[:, 0]), "do not belong"),
    ],
    ids=["no force", "nan", "transposed", "flat"],
)
def test_spectra_that_do_not_fit_are_rejected(spoil, says):
    with pytest.raises(DataError, match=says):
        combine_spectra(*spoil(*noisy()))


def test_lines_of_a_band_never_hold_zero():
    found = lines_of_band(2048, 2000.0, (0.0, 100.0))
    assert found[0] == 1
    assert found[-1] == 102


@pytest.mark.parametrize("band", [(50.0, 51.0), (100.0, 20.0), (np.nan, 20.0), (1200.0, 1300.0)])
def test_a_band_without_lines_is_rejected(band):
    with pytest.raises(DataError):
        lines_of_band(2048, 2000.0, band)


def plain(values, frequency=(1.0, 2.0, 3.0), quantity="receptance", shift=0.0):
    return Frf(np.array(frequency), np.array(values)[None, None], quantity, ("a",), (1,), (1,), damping_shift=shift)


def test_quantities_differ_by_powers_of_s_and_convert_back():
    s = 0.5 + 2j * np.pi * np.array([1.0, 2.0, 3.0])
    one = plain([1 + 0j, 2j, 3 - 1j], shift=0.5)
    inertance = convert_frf(one, "inertance")
    np.testing.assert_allclose(inertance.values, one.values * s**2)
    np.testing.assert_allclose(convert_frf(inertance, "receptance").values, one.values)


@pytest.mark.parametrize(
    ("values", "frequency", "says"),
    [
        ([1j, np.nan, 1], (1.0, 2.0, 3.0), "NaN"),
        ([1.0, 2.0, 3.0], (1.0, 2.0, 3.0), "phase"),
        ([1j, 1, 1], (3.0, 2.0, 1.0), "descends"),
        ([1j, 1, 1], (0.0, 2.0, 3.0), "0 Hz"),
    ],
    ids=["nan", "magnitude only", "descending", "zero"],
)
def test_what_cannot_be_converted_is_rejected(values, frequency, says):
    with pytest.raises(DataError, match=says):
        convert_frf(plain(values, frequency, "inertance"), "receptance")


def test_along_the_shifted_axis_a_truncated_block_gives_the_structures_own_frf():
    rng = np.random.default_rng(1)
    system, rig = bench.modes(rng), bench.rig(5)
    signals = to_signals_of(bench.impact_blocks(system, rng, hits=1, noise=1e-6, force_noise=1e-6), rig)
    shift = np.log(1e4) / 1.024
    errors = []
    for sigma in (0.0, shift):
        frf = impact_frf([signals], rig, (3.0, 300.0), damping_shift=sigma)
        s = sigma + 2j * np.pi * frf.frequency_hz
        w = 2 * np.pi * system.frequency_hz[:, None]
        modes = s**2 / (s**2 + 2 * system.zeta[:, None] * w * s + w**2)
        expected = np.einsum("mo,m,mk->ok", system.phi, system.phi[:, 4], modes)
        errors.append(np.abs(frf.values[:, 0] - expected).max() / np.abs(expected).max())
    assert errors[0] > 0.1
    assert errors[1] < 2e-3


def test_a_test_without_blocks_is_rejected():
    with pytest.raises(DataError, match="no block"):
        impact_frf([], bench.rig(5), (3.0, 300.0))
