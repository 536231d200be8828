"""The closed forms of a pole's response in a block, against time records made sample by sample."""

import numpy as np
import pytest

from modallab.identification.likelihood.basis import columns_of_block
from modallab.identification.likelihood.excitation import BlockLines, HitExcitation
from modallab.identification.likelihood.sine_block import tone_excitation

RATE, N = 1000.0, 1024
POLE = np.array([-0.8 + 2j * np.pi * 17.3])
EVERY = np.arange(1, N // 2)
GRID = BlockLines(2 * np.pi * EVERY * RATE / N, N, 1 / RATE, 2)


def smooth_hit():
    t = np.arange(N) / RATE - 0.08
    return np.exp(-0.5 * (t / 0.004) ** 2) * (np.abs(t) < 0.04)


def time_response(force, pole):
    """Receptance 1 / (s - pole) to a band-limited force, by the convolution integral on a fine grid."""
    fine = 8
    forced = np.fft.irfft(np.pad(np.fft.rfft(force), (0, (fine - 1) * N // 2)), fine * N) * fine
    dt = 1 / RATE / fine
    kernel = np.exp(pole * np.arange(fine * N) * dt)
    kernel[0] *= 0.5
    return np.fft.ifft(np.fft.fft(forced, 4 * N * fine) * np.fft.fft(kernel, 4 * N * fine))[: fine * N : fine] * dt


def test_forced_response_is_the_dft_of_the_truncated_ring_down():
    force = smooth_hit()
    position = time_response(force, POLE[0])
    velocity = POLE[0] * position + force
    slope = np.gradient(force, 1 / RATE)
    slope = np.fft.irfft(2j * np.pi * np.fft.rfftfreq(N, 1 / RATE) * np.fft.rfft(force), N)
    acceleration = POLE[0] * velocity + slope
    expected = np.fft.fft(acceleration)[EVERY]
    value, _ = HitExcitation(GRID, force, 0).forced(POLE)
    assert np.abs(value[0] - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.parametrize("start", [0, 80])
def test_free_decay_is_the_dft_of_its_samples(start):
    n = np.arange(N)
    samples = np.where(n >= start, POLE[0] ** 2 * np.exp(POLE[0] * (n - start) / RATE), 0)
    value, _ = HitExcitation(GRID, smooth_hit(), start).free(POLE)
    np.testing.assert_allclose(value[0], np.fft.fft(samples)[EVERY], rtol=1e-9)


@pytest.mark.parametrize("frequency", [27.34375, 11.3])
def test_a_tone_from_zero_state_is_the_dft_of_its_samples(frequency):
    amplitude = 0.7 - 0.4j
    s = 2j * np.pi * frequency
    t = np.arange(N) / RATE
    steady = [0.5 * a * w**2 / (w - POLE[0]) * np.exp(w * t) for a, w in ((amplitude, s), (np.conj(amplitude), -s))]
    state = 0.5 * (amplitude / (s - POLE[0]) + np.conj(amplitude) / (-s - POLE[0]))
    samples = steady[0] + steady[1] - state * POLE[0] ** 2 * np.exp(POLE[0] * t)
    value, _ = tone_excitation(GRID, frequency, amplitude, 0).forced(POLE)
    assert np.abs(value[0] - np.fft.fft(samples)[EVERY]).max() < 1e-9 * np.abs(samples).sum()


@pytest.mark.parametrize(
    "excitation",
    [HitExcitation(GRID, smooth_hit(), 80), tone_excitation(GRID, 18.1, 0.5 + 0.2j, 0)],
    ids=["hit", "tone"],
)
def test_derivatives_are_those_of_the_columns(excitation):
    omega, zeta = np.array([109.0, 380.0]), np.array([0.008, 0.004])
    state, drive = np.array([0.01 + 0.02j, -0.03j]), 0.02 - 0.01j

    def phi(o, z, q, d):
        return columns_of_block(excitation, o, z, q, d, (0, 2)).phi

    found = columns_of_block(excitation, omega, zeta, state, drive, (0, 2))
    coefficient = (
        np.random.default_rng(1).standard_normal((found.phi.shape[1], 1)) / np.linalg.norm(found.phi, axis=0)[:, None]
    )

    def change(vectors, parameter):
        part = vectors.parameter == parameter
        return vectors.values[:, part] @ coefficient[vectors.column[part]]

    h = 1e-6
    unit = np.array([1.0, 0.0])
    cases = [
        (
            found.poles,
            0,
            phi(omega + h * 100 * unit, zeta, state, drive),
            phi(omega - h * 100 * unit, zeta, state, drive),
            100 * h,
        ),
        (found.poles, 1, phi(omega, zeta + h * unit, state, drive), phi(omega, zeta - h * unit, state, drive), h),
        (found.local, 0, phi(omega, zeta, state + h * unit, drive), phi(omega, zeta, state - h * unit, drive), h),
        (
            found.local,
            1,
            phi(omega, zeta, state + 1j * h * unit, drive),
            phi(omega, zeta, state - 1j * h * unit, drive),
            h,
        ),
        (found.local, 4, phi(omega, zeta, state, drive + h), phi(omega, zeta, state, drive - h), h),
    ]
    for vectors, parameter, plus, minus, step in cases:
        numeric = (plus - minus) @ coefficient / (2 * step)
        assert np.abs(change(vectors, parameter) - numeric).max() < 1e-5 * np.abs(numeric).max()
