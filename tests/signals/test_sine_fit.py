import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.signals.tone_fit import fit_at, fit_frequency, strongest_line_near

RATE, N = 1000.0, 1024
T = np.arange(N) / RATE
AMPLITUDE = np.array([1.5 - 0.4j, 0.02j])


def record(frequency, noise=0.0, seed=1):
    clean = np.real(AMPLITUDE[:, None] * np.exp(2j * np.pi * frequency * T)) + np.array([[0.3], [-2.0]])
    return clean + noise * np.random.default_rng(seed).standard_normal(clean.shape)


@pytest.mark.parametrize("frequency", [27.34375, 26.9, 1.3])
def test_a_clean_sine_is_read_exactly_on_a_line_or_off_it(frequency):
    fit = fit_at(record(frequency), RATE, frequency)
    np.testing.assert_allclose(fit.amplitude, AMPLITUDE, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(fit.offset, [0.3, -2.0], rtol=1e-9)
    assert fit.residual_rms.max() < 1e-12


def test_the_frequency_is_found_from_half_a_line_away():
    fit = fit_frequency(record(26.9), RATE, 26.9 + 0.45 * RATE / N)
    assert fit.frequency_hz == pytest.approx(26.9, rel=1e-10)


def test_the_frequency_scatters_as_the_cramer_rao_bound_says():
    noise, frequency = 0.1, 26.9
    found = [fit_frequency(record(frequency, noise, seed)[:1], RATE, 27.0).frequency_hz for seed in range(200)]
    # sigma_f = sqrt(6 noise^2 / (pi^2 A^2 N)) / T (Rife and Boorstyn 1974).
    bound = np.sqrt(6 * noise**2 / (np.pi**2 * np.abs(AMPLITUDE[0]) ** 2 * N)) * RATE / N
    assert np.std(found) == pytest.approx(bound, rel=0.15)
    assert abs(np.mean(found) - frequency) < 4 * bound / np.sqrt(200)


def test_the_residual_is_the_noise():
    fit = fit_at(record(26.9, 0.1), RATE, 26.9)
    np.testing.assert_allclose(fit.residual_rms, 0.1, rtol=0.07)


def test_a_wrong_clock_is_looked_for_nearby():
    values = record(50.0 * 1.03)[0]
    assert strongest_line_near(values, RATE, 50.0) == pytest.approx(51.5, abs=0.2)
    assert strongest_line_near(record(50.1)[0], RATE, 50.0) == 50.0


def test_no_sine_where_it_should_be_is_rejected():
    with pytest.raises(DataError, match="no sine near"):
        fit_frequency(record(120.0), RATE, 100.0)


@pytest.mark.parametrize(
    ("values", "rate", "frequency", "says"),
    [
        (record(20.0) * np.nan, RATE, 20.0, "NaN"),
        (record(20.0).T, RATE, 20.0, "transposed"),
        (record(20.0)[0], RATE, 20.0, "shape"),
        (record(20.0), 0.0, 20.0, "rate"),
        (record(20.0), RATE, 600.0, "cannot be seen"),
        (record(20.0), RATE, np.nan, "frequency"),
        (record(20.0)[:, :4], RATE, 20.0, "at least 8"),
    ],
    ids=["nan", "transposed", "flat", "no rate", "beyond", "nan frequency", "short"],
)
def test_what_no_sine_can_be_fitted_to_is_rejected(values, rate, frequency, says):
    for fit in (fit_at, fit_frequency):
        with pytest.raises(DataError, match=says):
            fit(values, rate, frequency)


def test_zeros_have_no_amplitude_and_keep_their_frequency():
    fit = fit_frequency(np.zeros((1, N)), RATE, 20.0)
    assert fit.amplitude[0] == 0
    assert fit.frequency_hz == 20.0
