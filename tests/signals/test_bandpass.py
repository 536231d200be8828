import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.signals.transform import bandpass

RATE, N = 2000.0, 8192
T = np.arange(N) / RATE
MIDDLE = slice(3000, 5000)


def test_a_sine_in_the_band_passes_with_its_phase_and_one_outside_does_not():
    inside, outside = np.sin(2 * np.pi * 40 * T), np.sin(2 * np.pi * 400 * T)
    found = bandpass(np.stack([inside, outside]), RATE, (3.0, 110.0))
    np.testing.assert_allclose(found[0, MIDDLE], inside[MIDDLE], atol=5e-3)
    assert np.abs(found[1, MIDDLE]).max() < 3e-3


def test_there_is_no_delay():
    pulse = np.zeros(N)
    pulse[4000] = 1.0
    found = bandpass(pulse, RATE, (3.0, 110.0))
    assert np.argmax(np.abs(found)) == 4000
    np.testing.assert_allclose(found[4000 - 500 : 4000], found[4000 + 500 : 4000 : -1], atol=1e-15)


def test_the_edges_halve_the_amplitude_and_a_constant_vanishes():
    for edge in (20.0, 110.0):
        found = bandpass(np.cos(2 * np.pi * edge * T), RATE, (20.0, 110.0))
        assert np.abs(found[MIDDLE]).max() == pytest.approx(0.5, abs=0.01)
    assert np.abs(bandpass(np.ones(N), RATE, (20.0, 110.0))[MIDDLE]).max() < 5e-3


@pytest.mark.parametrize("band", [(0.0, 100.0), (100.0, 50.0), (3.0, 1000.0), (np.nan, 100.0)])
def test_a_band_that_does_not_fit_is_rejected(band):
    with pytest.raises(DataError, match="does not fit"):
        bandpass(T, RATE, band)


@pytest.mark.parametrize(
    ("values", "rate", "taps", "says"),
    [
        (np.where(T == 0, np.nan, T), RATE, None, "NaN"),
        (T, -1.0, None, "rate"),
        (T, RATE, 100, "odd"),
        (np.ones((64, 2)), RATE, None, "transposed"),
        (T * 1j, RATE, None, "real"),
    ],
)
def test_what_cannot_be_filtered_is_rejected(values, rate, taps, says):
    with pytest.raises(DataError, match=says):
        bandpass(values, rate, (3.0, 110.0), taps)
