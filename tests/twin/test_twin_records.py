"""Predicted records against plain integration of the same modes in time."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from modallab.core.rig import Beam
from modallab.twin.bench import MeasurementChain, Mount, Twin, chain_transfer
from modallab.twin.modes import solve_modes
from modallab.twin.predict import predict_hit, predict_sine
from modallab.twin.response import SineStartUp
from modallab.twin.structure import TwinStructure

BEAM = Beam(length_m=1.0, width_m=0.05, thickness_m=0.006, youngs_modulus_pa=2.05e11, density_kg_m3=7850.0)
TWIN = Twin(TwinStructure.of(BEAM, 0.006))
CHANNELS, X = (4, 10), np.array([0.4, 1.0])


def integrate(twin: Twin, force: np.ndarray, dt: float, drive_x: float) -> np.ndarray:
    """Accelerations by exact steps of each mode between samples, force linear in between."""
    modes = solve_modes(twin.structure)
    total = np.zeros((len(X), len(force)))
    for p, pole in enumerate(modes.poles):
        omega, zeta = abs(pole), -pole.real / abs(pole)
        num, den, _ = cont2discrete(([1.0, 0, 0], [1.0, 2 * zeta * omega, omega**2]), dt, method="foh")
        q = lfilter(num.ravel(), den, force)
        out = modes.shapes_at(X)[:, p] * np.sqrt(2j * pole.imag)
        drive = modes.shapes_at(drive_x)[0, p] * np.sqrt(2j * pole.imag)
        total += np.outer((out * drive).real, q)
    return total


def test_a_hit_rings_as_its_modes_integrated_in_time_do() -> None:
    fine, step, n = 20, 1 / 2000, 1024
    t = np.arange(n * fine) * step / fine
    force = np.where((t > 0.05) & (t < 0.06), np.sin(np.pi * (t - 0.05) / 0.01) ** 4, 0.0) * 50
    expected = integrate(TWIN, force, step / fine, 0.6)[:, ::fine]
    predicted = predict_hit(TWIN, force[::fine], 1 / step, 0.6, CHANNELS, X, 0.0)
    assert np.abs(predicted - expected).max() < 2e-3 * np.abs(expected).max()


def test_a_sine_block_still_rings_from_its_start_eight_seconds_before() -> None:
    rate, fine, f0 = 1000, 4, 5.0
    t = np.arange(9 * rate * fine) / rate / fine
    force = np.minimum(t, 1.0) * np.cos(2 * np.pi * f0 * t + 0.4)
    block = slice(8 * rate * fine, (8 * rate + 800) * fine, fine)
    expected = integrate(TWIN, force, 1 / rate / fine, 0.4)[:, block]
    amplitude = np.exp(1j * (0.4 + 2 * np.pi * f0 * 8))
    predicted = predict_sine(TWIN, complex(amplitude), f0, 800, rate, 0.4, CHANNELS, X, 0.0)
    assert np.abs(predicted - expected).max() < 2e-3 * np.abs(expected).max()


@pytest.mark.parametrize("f0", [4.9, 5.0, 33.0])
def test_a_sine_that_rises_along_a_cosine_leaves_the_decay_its_history_says(f0: float) -> None:
    rate, fine, ramp, history = 1000, 4, 0.4, 2.5
    t = np.arange(4 * rate * fine) / rate / fine
    force = (1 - np.cos(np.pi * np.minimum(t / ramp, 1.0))) / 2 * np.cos(2 * np.pi * f0 * t + 0.4)
    first = int(history * rate) * fine
    expected = integrate(TWIN, force, 1 / rate / fine, 0.4)[:, first : first + 800 * fine : fine]
    amplitude = complex(np.exp(1j * (0.4 + 2 * np.pi * f0 * history)))
    yes = np.ones(1, dtype=np.bool_)
    rise = SineStartUp(np.array([history]), np.array([ramp]), yes, yes)
    predicted = predict_sine(TWIN, amplitude, f0, 800, rate, 0.4, CHANNELS, X, 0.0, rise)
    assert np.abs(predicted - expected).max() < 2e-3 * np.abs(expected).max()
    usual = predict_sine(TWIN, amplitude, f0, 800, rate, 0.4, CHANNELS, X, 0.0)
    assert np.abs(usual - expected).max() > 0.02 * np.abs(expected).max()


def test_a_sine_switched_on_at_once_is_the_limit_of_both_rises() -> None:
    a = np.array([[0.3 + 4j, 0.2 - 30j]])
    yes, no, history = np.ones(2, dtype=np.bool_), np.zeros(2, dtype=np.bool_), np.full(2, 2.0)
    sudden = -np.exp(-2.0 * a) / a
    for cosine in (yes, no):
        assert SineStartUp(history, np.zeros(2), cosine, yes).remaining_transient(a) == pytest.approx(sudden, rel=1e-4)


def test_the_twin_with_its_rest_bends_statically_as_the_whole_beam_does() -> None:
    for masses in ((), ((0.7, 0.3),)):
        structure = replace(TWIN.structure, masses=masses, root_rotation=1 / 13)
        modes, s = solve_modes(structure), structure
        kept = 2 * np.real((modes.shapes_at(X) * modes.shapes_at(0.6)[0]) @ (-1 / modes.poles))
        x, a, ei = X, 0.6, s.bending_stiffness
        low, high = np.minimum(x, a), np.maximum(x, a)
        closed = low**2 * (3 * high - low) / 6 / ei + x * a * s.root_rotation * s.length_m / ei
        assert kept + modes.remainder(X, 0.6) == pytest.approx(closed, rel=3e-8)
        assert np.all(np.abs(kept - closed) > 5e-7 * closed)


def test_the_rest_adds_to_a_hit_what_the_force_itself_presses() -> None:
    force = np.zeros(512)
    force[50:90] = np.hanning(40)
    twins = (replace(TWIN, residual_compliance=r) for r in (1.0, 0.0))
    whole, few = (predict_hit(twin, force, 2000.0, 0.6, CHANNELS, X, 0.0) for twin in twins)
    s = 2j * np.pi * np.fft.rfftfreq(512, 1 / 2000)
    pressed = np.fft.irfft(np.fft.rfft(force) * s**2, 512)
    expected = np.outer(solve_modes(TWIN.structure).remainder(X, 0.6), pressed)
    assert whole - few == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_a_clock_that_runs_fast_makes_everything_look_slower() -> None:
    force = np.zeros(2048)
    force[100:110] = np.hanning(10)
    slow = predict_hit(replace(TWIN, clock=0.02), force, 2000.0, 1.0, CHANNELS, X, 0.0)
    plain = predict_hit(TWIN, force, 2000.0, 1.0, CHANNELS, X, 0.0)

    def centre(y: np.ndarray) -> float:
        # Of mode 1, well below mode 2.
        z = np.abs(np.fft.rfft(y[1] * np.hanning(2048), 2**17))
        hz = np.fft.rfftfreq(2**17, 1 / 2000.0)
        return float(hz[(hz > 2) & (hz < 9)][np.argmax(z[(hz > 2) & (hz < 9)])])

    assert centre(slow) / centre(plain) == pytest.approx(1 / 1.02, rel=2e-3)


def test_the_chain_has_the_phases_its_words_promise() -> None:
    s = 2j * np.pi * np.array([10.0])
    delay = chain_transfer(MeasurementChain(delay_s=1e-3), CHANNELS, s)
    assert np.angle(delay[:, 0]) == pytest.approx([-2 * np.pi * 0.01] * 2)
    skew = chain_transfer(MeasurementChain(skew_s=1e-5), CHANNELS, s)
    assert np.angle(skew[:, 0]) == pytest.approx([2 * np.pi * 10 * 4e-5, 2 * np.pi * 10 * 1e-4])
    corner = chain_transfer(MeasurementChain(corner_hz=10.0), CHANNELS, s)
    assert np.abs(corner[0, 0]) == pytest.approx(1 / np.sqrt(2))
    mount = chain_transfer(MeasurementChain(mounts=(Mount(10, 10.0, 0.05),)), CHANNELS, s)
    assert np.abs(mount[:, 0]) == pytest.approx([1.0, np.sqrt(1 + 0.1**2) / 0.1])


def test_a_swap_exchanges_rows_and_a_turned_sensor_its_sign() -> None:
    force = np.zeros(512)
    force[50:60] = 1.0
    plain = predict_hit(TWIN, force, 2000.0, 0.6, CHANNELS, X, 0.0)
    swapped = predict_hit(replace(TWIN, chain=MeasurementChain(swap=(4, 10))), force, 2000.0, 0.6, CHANNELS, X, 0.0)
    turned = predict_hit(replace(TWIN, chain=MeasurementChain(gain={10: -1.0})), force, 2000.0, 0.6, CHANNELS, X, 0.0)
    assert swapped == pytest.approx(plain[::-1])
    assert turned[1] == pytest.approx(-plain[1])


def test_drift_lowers_the_last_record_and_not_the_first() -> None:
    drifting = replace(TWIN, ei_drift=-0.1)
    force = np.zeros(512)
    force[50:60] = 1.0
    first, last = (predict_hit(drifting, force, 2000.0, 0.6, CHANNELS, X, tau) for tau in (0.0, 1.0))
    assert first == pytest.approx(predict_hit(TWIN, force, 2000.0, 0.6, CHANNELS, X, 0.0))
    softer = replace(TWIN, structure=replace(TWIN.structure, youngs_modulus_pa=0.9 * TWIN.structure.youngs_modulus_pa))
    assert last == pytest.approx(predict_hit(softer, force, 2000.0, 0.6, CHANNELS, X, 0.0), rel=1e-6, abs=1e-9)
