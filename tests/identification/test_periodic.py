"""Periodic excitation in responses alone is named, and taken for no mode; a mode is never taken for it."""

import numpy as np
import pytest

from modallab.identification.response_only.modes import response_modes
from modallab.identification.response_only.periodic import line_at, lines_in_words, steady_lines, without_line

RATE_HZ, SECONDS = 100.0, 400.0
MODES, ZETA = np.array([4.0, 11.5, 19.0]), np.array([0.01, 0.012, 0.009])
LINES = np.array([6.25, 12.5, 18.75])
SHAPES = np.random.default_rng(7).normal(size=(5, 3))


def records(level: float, wander: float = 0.0, seed: int = 1, modes=MODES, zeta=ZETA) -> np.ndarray:
    """Accelerations (5, samples) under white forces, and of lines whose phase wanders by so many rad in a second."""
    rng = np.random.default_rng(seed)
    n = int(RATE_HZ * SECONDS)
    omega, t = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE_HZ), np.arange(n) / RATE_HZ
    y = np.zeros((5, n))
    for f, z, shape in zip(modes, zeta, SHAPES.T, strict=False):
        w = 2 * np.pi * f
        frf = omega**2 / (w**2 - omega**2 + 2j * z * w * omega)
        y += np.outer(shape, np.fft.irfft(np.fft.rfft(rng.normal(size=n)) * frf, n))
    size, where = level * y.std(), rng.normal(size=(5, 3))
    for k, f in enumerate(LINES):
        phase = wander * np.cumsum(rng.normal(size=n)) / np.sqrt(RATE_HZ)
        y += size * np.outer(where[:, k], np.cos(2 * np.pi * f * t + rng.uniform(0, 6) + phase))
    return y + 0.02 * y.std() * rng.normal(size=y.shape)


@pytest.mark.thorough("identifies each recording twice")
@pytest.mark.parametrize(("level", "wander"), [(0.5, 0.0), (2.0, 0.05)])
def test_lines_are_named_and_only_modes_remain(level, wander):
    found = response_modes([records(level, wander)], RATE_HZ, (1.0, 30.0))
    np.testing.assert_allclose(found.frequency_hz, MODES, rtol=3e-3)
    np.testing.assert_allclose(found.damping_ratio, ZETA, rtol=0.3)
    np.testing.assert_allclose(found.harmonics_hz, LINES, rtol=5e-3)
    assert np.all(found.confidence > 0.6)


@pytest.mark.parametrize("seed", range(3))
def test_random_responses_hold_no_lines(seed):
    assert response_modes([records(0.0, seed=seed)], RATE_HZ, (1.0, 30.0)).harmonics_hz.size == 0


def test_a_mode_that_hardly_decays_is_no_line():
    """Its phase goes on for a while; its own damping says for how long."""
    record = records(0.0, modes=[5.0], zeta=[1e-3])
    assert line_at(record, RATE_HZ, 5.0, 1e-3) is None
    found = response_modes([record], RATE_HZ, (1.0, 30.0))
    np.testing.assert_allclose(found.frequency_hz, [5.0], rtol=1e-3)
    assert found.harmonics_hz.size == 0


def test_a_line_is_taken_out_to_its_ends():
    t = np.arange(40_000) / RATE_HZ
    noise = 1e-3 * np.random.default_rng(1).normal(size=(2, t.size))
    line = np.array([[1.0], [0.5]]) * np.cos(2 * np.pi * 7.3 * t + 0.4) + noise
    (hz,) = steady_lines(line, RATE_HZ, (1.0, 40.0))
    assert hz == pytest.approx(7.3, rel=1e-6)
    assert np.abs(without_line(line, RATE_HZ, hz)).max() < 0.02


def test_orders_of_one_speed_are_said():
    assert "(orders 1, 2, 3 of 6.25 Hz)" in lines_in_words(LINES)
    assert "orders" not in lines_in_words([6.25, 9.1])


def of_one(wander: float, noise: float, seed: int) -> np.ndarray:
    """Records (3, samples) of 400 s: a mode at 10 Hz of 0.4 %, and a line at 27 Hz whose phase wanders, in noise."""
    rng, n = np.random.default_rng(seed), 40_000
    omega, w = 2 * np.pi * np.fft.rfftfreq(n, 0.01), 2 * np.pi * 10.0
    answer = np.fft.irfft(np.fft.rfft(rng.normal(size=n)) / (w**2 - omega**2 + 0.008j * w * omega), n)
    phase = 2 * np.pi * 27.0 * np.arange(n) / 100 + wander * np.cumsum(rng.normal(size=n)) / 10
    y = np.outer(rng.normal(size=3), answer / answer.std()) + np.outer(rng.normal(size=3), np.cos(phase))
    return y + noise * rng.normal(size=y.shape)


@pytest.mark.parametrize("wander", [0.1, 0.2, 0.4])
def test_a_line_whose_phase_wanders_off_few_times_in_the_record_is_one_and_a_mode_is_none(wander: float) -> None:
    """As a damping ratio its width is wander^2 / (4 pi f); the record holds from 2 to 32 of its decays."""
    for seed in range(8):
        record = of_one(wander, 0.1, seed)
        line = line_at(record, 100.0, 27.0, wander**2 / (4 * np.pi * 27.0))
        assert line == pytest.approx(27.0, abs=0.1)
        assert line_at(record, 100.0, 10.0, 4e-3) is None
