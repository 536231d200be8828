"""The beam in time against its analytic frequency response, its energy and its decay."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab_simulators.cantilever.basis import ModalBasis
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.hammer import ContactPulse
from modallab_simulators.cantilever.loads import BLOCK, BeamLoad, SensorOutput
from modallab_simulators.cantilever.recursion import DELAY, lowpass_taps
from modallab_simulators.cantilever.structure import LinearStructure
from modallab_simulators.cantilever.truth import oversampling

BEAM = CantileverBeam(0.777, 205e9 * 0.05 * 0.004**3 / 12, 7850 * 0.05 * 0.004, 13.0)
X = BEAM.length_m * np.arange(1, 11) / 10
OUTPUTS = (SensorOutput("force"), *(SensorOutput("motion", float(x), 2) for x in X))

Floats = NDArray[np.float64]


def basis(rate_hz: float, zeta: float) -> ModalBasis:
    count = BEAM.count_below(2 * math.pi * 0.4 * rate_hz * oversampling(rate_hz))
    return ModalBasis(BEAM, BEAM.omega(count), np.full(count, zeta))


def strike(structure: Any, rate_hz: float, x_m: float, contact: ContactPulse, blocks: int) -> tuple[Floats, Any]:
    state, pieces = structure.at_rest, []
    for block in range(blocks):
        first, count = structure.times(block)
        times = np.arange(first, first + count) / (rate_hz * structure.oversample)
        force = contact.force(times)
        seen, state = structure.advance(state, [BeamLoad(x_m, force)] if force.any() else [])
        pieces.append(seen)
    return np.concatenate(pieces, axis=1), state


def receptance(modes: ModalBasis, x_m: Floats, force_x_m: float, omega: Floats) -> NDArray[np.complex128]:
    phi = modes.shapes(x_m) * modes.shapes(np.array([force_x_m]))
    poles = modes.omega**2 - omega[:, None] ** 2 + 2j * modes.zeta * modes.omega * omega[:, None]
    return phi @ (1 / poles).T + modes.remainder(x_m, force_x_m)[:, None]


@pytest.mark.parametrize(
    ("rate_hz", "point"), [(2000.0, 9), (2000.0, 2), (1000.0, 5), (1651.6, 9), (10_000.0, 3), (100.0, 9)]
)
def test_response_to_a_hit_is_the_analytic_response(rate_hz: float, point: int):
    modes = basis(rate_hz, 0.03)
    structure = LinearStructure(modes, OUTPUTS, rate_hz, oversampling(rate_hz))
    blocks = math.ceil(45 * rate_hz / BLOCK)
    contact = ContactPulse(0.0123, max(0.0015, 1.6 / rate_hz), 100.0)
    seen, _ = strike(structure, rate_hz, float(X[point]), contact, blocks)
    f = np.fft.rfftfreq(seen.shape[1], 1 / rate_hz)
    spectra = np.fft.rfft(seen, axis=1)
    used = (f > 0.01) & (f < 0.4 * rate_hz) & (np.abs(spectra[0]) > 1e-3 * np.abs(spectra[0]).max())
    omega = 2 * math.pi * f[used]
    exact = -(omega**2) * receptance(modes, X, float(X[point]), omega)
    error = np.abs(spectra[1:, used] / spectra[0, used] - exact)
    # Relative to each channel's response, with the driving points' level as the floor at antiresonances.
    assert (error / np.maximum(np.abs(exact), 0.1)).max() < 1e-4


def test_velocity_displacement_and_voltage_are_seen_alike():
    modes, rate_hz = basis(2000.0, 0.03), 2000.0
    outputs = (
        SensorOutput("force"),
        *(SensorOutput("motion", float(X[9]), d) for d in range(3)),
        SensorOutput("voltage"),
    )
    structure = LinearStructure(modes, outputs, rate_hz, 4)
    state, pieces = structure.at_rest, []
    for block in range(94):
        first, count = structure.times(block)
        force = ContactPulse(0.02, 0.002, 50.0).force(np.arange(first, first + count) / 8000)
        seen, state = structure.advance(state, [BeamLoad(float(X[3]), force, 4.0)] if force.any() else [])
        pieces.append(seen)
    spectra = np.fft.rfft(np.concatenate(pieces, axis=1), axis=1)
    f = np.fft.rfftfreq(94 * BLOCK, 1 / rate_hz)
    used = (f > 2) & (f < 800)
    omega = 2 * math.pi * f[used]
    exact = receptance(modes, X[9:], float(X[3]), omega)[0]
    for d in range(3):
        expected = (1j * omega) ** d * exact
        found = spectra[1 + d, used] / spectra[0, used]
        assert (np.abs(found - expected) / np.maximum(np.abs(expected), 0.1 * omega ** (d - 2))).max() < 1e-4
    np.testing.assert_allclose(spectra[4, used] / spectra[0, used], 4.0, rtol=1e-9)


def test_reciprocity():
    modes = basis(2000.0, 0.005)
    structure = LinearStructure(modes, OUTPUTS, 2000.0, 4)
    contact = ContactPulse(0.01, 0.003, 80.0)
    at_three, _ = strike(structure, 2000.0, float(X[2]), contact, 3)
    at_ten, _ = strike(structure, 2000.0, float(X[9]), contact, 3)
    np.testing.assert_allclose(at_three[10], at_ten[3], rtol=0, atol=1e-10 * np.abs(at_ten).max())


def test_energy_of_every_mode_is_what_the_hit_put_in():
    """Undamped, a hit leaves |z| = phi |F(omega)| in each mode; F of a sin^2 pulse in closed form."""
    modes = basis(2000.0, 1e-12)
    structure = LinearStructure(modes, OUTPUTS, 2000.0, 4)
    contact = ContactPulse(0.01, 0.004, 80.0)
    _, state = strike(structure, 2000.0, float(X[9]), contact, 2)
    turns = modes.omega * contact.width_s / (2 * math.pi)
    pulse = contact.peak_n * contact.width_s / 2 * np.abs(np.sinc(turns) / (1 - turns**2))
    expected = modes.shapes(X[9:])[0] ** 2 * pulse**2 / 2
    in_band = modes.omega < 2 * math.pi * 800
    np.testing.assert_allclose(
        np.abs(state[in_band]) ** 2 / 2, expected[in_band], rtol=1e-5, atol=1e-6 * expected.max()
    )


def test_free_decay_is_exact():
    """Once the higher modes are gone, y[n+1] - 2 Re(lambda) y[n] + |lambda|^2 y[n-1] = 0 to rounding."""
    modes = basis(2000.0, 0.02)
    modes = ModalBasis(BEAM, modes.omega, np.where(np.arange(len(modes.omega)) == 0, 0.004, 0.19))
    structure = LinearStructure(modes, OUTPUTS, 2000.0, 4)
    seen, _ = strike(structure, 2000.0, float(X[9]), ContactPulse(0.01, 0.004, 80.0), 10)
    y = seen[10, 4 * BLOCK :]
    pole = np.exp(modes.poles[0] / 2000.0)
    residue = y[2:] - 2 * pole.real * y[1:-1] + abs(pole) ** 2 * y[:-2]
    assert np.abs(residue).max() < 1e-12 * np.abs(y).max()
    # The logarithmic decrement over whole periods, read off the envelope, is 2 pi zeta / sqrt(1 - zeta^2).
    energy = np.array([np.sum(y[k * 417 : (k + 1) * 417] ** 2) for k in (0, 6)])
    assert math.log(energy[0] / energy[1]) / 2 / (6 * 417 / 2000) == pytest.approx(-modes.poles[0].real, rel=0.01)


def test_driven_and_free_ways_agree():
    modes = basis(2000.0, 0.005)
    structure = LinearStructure(modes, OUTPUTS, 2000.0, 4)
    rng = np.random.default_rng(3)
    state = rng.standard_normal(len(modes.omega)) + 1j * rng.standard_normal(len(modes.omega))
    free, after = structure.advance(state.copy(), [])
    _, count = structure.times(0)
    driven, after_driven = structure.advance(state.copy(), [BeamLoad(float(X[3]), np.zeros(count))])
    np.testing.assert_allclose(driven, free, rtol=0, atol=1e-11 * np.abs(free).max())
    np.testing.assert_allclose(after_driven, after, rtol=1e-11)


def test_a_beam_at_rest_stays_exactly_at_rest():
    structure = LinearStructure(basis(2000.0, 0.005), OUTPUTS, 2000.0, 4)
    seen, state = structure.advance(structure.at_rest, [])
    assert not seen.any()
    assert not state.any()


def test_superposition_of_two_forces():
    modes = basis(2000.0, 0.005)
    structure = LinearStructure(modes, OUTPUTS, 2000.0, 4)
    first, count = structure.times(0)
    times = np.arange(first, first + count) / 8000
    a = BeamLoad(float(X[9]), ContactPulse(0.05, 0.003, 50.0).force(times))
    b = BeamLoad(float(X[3]), np.sin(2 * math.pi * 50 * times) * (times > 0))
    both, _ = structure.advance(structure.at_rest, [a, b])
    alone = sum(structure.advance(structure.at_rest, [d])[0] for d in (a, b))
    np.testing.assert_allclose(both, alone, rtol=0, atol=1e-10 * np.abs(both).max())


@pytest.mark.parametrize("oversample", [4, 8, 80])
def test_filter_is_flat_linear_phase_and_stops_what_would_fold_back(oversample: int):
    taps = lowpass_taps(oversample)
    np.testing.assert_allclose(taps, taps[::-1], rtol=0, atol=1e-17)
    assert len(taps) == 2 * DELAY * oversample + 1
    response = np.abs(np.fft.rfft(taps, 1 << 17))
    f = np.fft.rfftfreq(1 << 17, 1 / oversample)
    assert np.abs(response[f < 0.44] - 1).max() < 1e-5
    assert 20 * np.log10(response[f > 0.56].max()) < -100
