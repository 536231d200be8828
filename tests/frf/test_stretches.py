import numpy as np
import pytest
from scipy import signal

from modallab.core.errors import DataError
from modallab.frf.broadband import segment_spectra
from modallab.frf.references import estimate_frf

RATE = 256.0


def test_stretches_without_overlap_are_the_blocks():
    values = np.random.default_rng(0).standard_normal((2, 640))
    found = segment_spectra(values, RATE, 128, overlap=0, window="none")
    blocks = values.reshape(2, 5, 128).swapaxes(0, 1)
    np.testing.assert_allclose(found.spectra, np.fft.rfft(blocks)[..., 1:64], atol=1e-12)
    np.testing.assert_allclose(found.frequency_hz, np.arange(1, 64) * 2.0)
    assert found.averages == 5


@pytest.mark.parametrize(("window", "overlap"), [("hann", 0.5), ("hann", 0.67), ("none", 0.5), ("hann", 0.0)])
def test_the_count_is_what_the_scatter_of_averaged_power_says(window, overlap):
    rng = np.random.default_rng(1)
    power = []
    for _ in range(200):
        found = segment_spectra(rng.standard_normal((1, 1024)), RATE, 128, overlap, window)
        power.append(np.mean(np.abs(found.spectra[:, 0, 4:-4]) ** 2, axis=0))
    scatter = np.mean(np.std(power, axis=0) ** 2) / np.mean(power) ** 2
    assert 1 / scatter == pytest.approx(found.averages, rel=0.08)


def test_overlap_makes_more_of_one_record():
    values = np.random.default_rng(2).standard_normal((1, 4096))
    apart, over = (segment_spectra(values, RATE, 256, overlap) for overlap in (0.0, 0.5))
    assert over.averages > 1.7 * apart.averages


def test_two_forces_in_one_long_record_are_distinguished():
    rng = np.random.default_rng(3)
    force = rng.standard_normal((2, 2**15))
    b, a = signal.butter(2, 0.3)
    response = np.stack([signal.lfilter(b, a, force[0]) + 0.5 * force[1]]) + 0.01 * rng.standard_normal((1, 2**15))
    found = segment_spectra(np.vstack([force, response]), RATE, 256)
    estimate = estimate_frf(found.spectra[:, :2], found.spectra[:, 2:], "Hv", averages=found.averages)
    _, true = signal.freqz(b, a, 2 * np.pi * found.frequency_hz / RATE)
    assert np.mean(np.abs(estimate.frf[0, 0] - true) < 1.5 * estimate.confidence_radius(0.95)[0, 0]) > 0.95
    np.testing.assert_allclose(estimate.frf[0, 1], 0.5, atol=0.01)


@pytest.mark.parametrize(
    ("values", "rate", "length", "overlap", "says"),
    [
        (np.full((1, 64), np.nan), RATE, 16, 0.5, "NaN"),
        (np.ones((1, 64)), RATE, 65, 0.5, "stretches of 65"),
        (np.ones((1, 64)), RATE, 4, 0.5, "stretches of 4"),
        (np.ones(64), RATE, 16, 0.5, "stretches of 16"),
        (np.ones((64, 1)), RATE, 16, 0.5, "transposed"),
        (np.ones((1, 0)), RATE, 16, 0.5, "empty"),
        (np.ones((1, 64)), -RATE, 16, 0.5, "rate"),
        (np.ones((1, 64)), RATE, 16, 1.0, "overlap"),
        (np.ones((1, 64)), RATE, 16, np.nan, "overlap"),
    ],
    ids=["NaN", "long", "short", "one axis", "transposed", "empty", "rate", "whole overlap", "NaN overlap"],
)
def test_what_cannot_be_cut_is_rejected(values, rate, length, overlap, says):
    with pytest.raises(DataError, match=says):
        segment_spectra(values, rate, length, overlap)
