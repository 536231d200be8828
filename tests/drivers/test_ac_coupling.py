"""AC coupling as a property of the rig: where channels differ in it, it is undone, and the model is as without."""

from dataclasses import replace

import numpy as np
import pytest
from modal_bench import Modes, block, impact_blocks, modes
from modal_bench import rig as rig_of

from modallab.core.block import Block
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.impact import identify_impact
from modallab.identification.options import IdentificationOptions
from modallab.identification.sine import identify_sine
from modallab.signals.ac_coupling import undo_ac_coupling
from modallab.signals.signals import to_signals_of

CORNER_HZ = 0.5
POINTS = 5


def high_pass(rows: np.ndarray, rate_hz: float, corner_hz: float) -> np.ndarray:
    """The coupling of band-limited rows that begin at rest, in the frequency domain, so long that nothing wraps."""
    n = rows.shape[-1]
    padded = 32 * n
    s = 2j * np.pi * np.fft.rfftfreq(padded, 1 / rate_hz)
    spectrum = np.fft.rfft(rows, padded) * s / (s + 2 * np.pi * corner_hz)
    return np.fft.irfft(spectrum, padded)[..., :n]


def coupled_rig(force: float, responses: float, points: int = POINTS) -> Rig:
    plain = rig_of(points)
    corners = [force] + [responses] * points
    channels = tuple(
        c.model_copy(update={"ac_corner_hz": corner}) for c, corner in zip(plain.channels, corners, strict=True)
    )
    return plain.model_copy(update={"channels": channels})


def coupled(dc: Block, offset: float = 0.0) -> Block:
    """The block as it would be read with AC-coupled responses and a converter that is off by a little."""
    samples = np.array(dc.samples, dtype=float)
    samples[1:] = high_pass(samples[1:], dc.rate_hz, CORNER_HZ) + offset
    return replace(dc, samples=samples)


@pytest.mark.parametrize("hz", [2.0, 4.8828125, 20.0, 105.0])
def test_the_phase_of_a_sine_is_given_back(hz: float) -> None:
    rate, rig = 1000.0, coupled_rig(0.0, CORNER_HZ)
    t = np.arange(1024) / rate
    true = np.exp(2j * np.pi * hz * t)
    turn = 1j * hz / (1j * hz + CORNER_HZ)
    read = np.stack([true.real] + [(turn * true).real + 0.2] * POINTS)
    # 5.9 degrees at 4.8 Hz, as a 0.5 Hz corner makes.
    assert np.degrees(np.angle(1j * 4.8 / (1j * 4.8 + 0.5))) == pytest.approx(5.9, abs=0.05)
    found = undo_ac_coupling(read, rate, rig, hz)[1:]
    basis = np.column_stack([true.real, -true.imag, np.ones_like(t)])
    amplitude = np.linalg.lstsq(basis, found.T, rcond=None)[0]
    np.testing.assert_allclose(amplitude[0] + 1j * amplitude[1], 1.0, atol=1e-5)


def test_channels_that_are_coupled_alike_are_left_as_they_are() -> None:
    values = np.random.default_rng(1).standard_normal((POINTS + 1, 300))
    assert undo_ac_coupling(values, 1000.0, coupled_rig(0.5, 0.5), 20.0) is values
    assert undo_ac_coupling(values, 1000.0, coupled_rig(0.0, 0.0)) is values


def test_a_transient_comes_back_as_it_was_but_for_a_constant() -> None:
    rng = np.random.default_rng(2)
    (dc,) = impact_blocks(modes(rng), rng, hits=1, noise=0.0, force_noise=1e-3)
    read = coupled(dc, offset=0.05)
    found = undo_ac_coupling(np.array(read.samples), dc.rate_hz, coupled_rig(0.0, CORNER_HZ))
    lost, left = (values[1:] - dc.samples[1:] for values in (read.samples, found))
    lost, left = (np.abs(error - error.mean(axis=1, keepdims=True)).max() for error in (lost, left))
    assert left < 0.03 * lost


def apart(one: ModalModel, other: ModalModel) -> float:
    """Largest difference of frequency, damping and constants, in the first one's sigmas."""
    constants = np.abs(one.modal_constants - other.modal_constants) / one.modal_constant_sigma
    return float(
        max(
            (np.abs(one.frequency_hz - other.frequency_hz) / one.frequency_sigma_hz).max(),
            (np.abs(one.damping_ratio - other.damping_ratio) / one.damping_sigma).max(),
            np.nanmax(constants),
        )
    )


def off(model: ModalModel, system: Modes) -> np.ndarray:
    """Errors of frequency, damping and constants, these as rms over the outputs, in the model's own sigmas."""
    assert model.modal_constant_part_sigma is not None
    away = model.modal_constants - system.phi[:, :, None] * system.phi[:, [POINTS - 1], None].transpose(0, 2, 1)
    parts = model.modal_constant_part_sigma
    constants = np.stack([away.real / parts.real, away.imag / parts.imag])
    return np.concatenate(
        [
            (model.frequency_hz - system.frequency_hz) / model.frequency_sigma_hz,
            (model.damping_ratio - system.zeta) / model.damping_sigma,
            np.sqrt(np.mean(constants**2, axis=(2, 3))).ravel(),
        ]
    )


def impact_errors(seed: int) -> list[np.ndarray]:
    """Errors of the models of DC-coupled channels, and of AC-coupled ones with the corner stated and not stated."""
    rng = np.random.default_rng(seed)
    system = modes(rng)
    blocks = impact_blocks(system, rng, hits=3)
    read = [coupled(block, offset=0.02) for block in blocks]

    def model(of: list[Block], rig: Rig) -> ModalModel:
        return identify_impact(to_signals_of(of, rig), rig, IdentificationOptions(band_hz=(3.0, 250.0)))[0]

    unreported, reported = coupled_rig(0.0, 0.0), coupled_rig(0.0, CORNER_HZ)
    return [off(model(of, rig), system) for of, rig in ((blocks, unreported), (read, reported), (read, unreported))]


@pytest.mark.thorough("records and identifies whole tests")
def test_the_impact_model_is_as_good_as_that_of_dc_coupled_channels() -> None:
    clean, reported, unreported = np.sqrt(
        np.mean(np.square([impact_errors(seed) for seed in (4, 5, 6, 7)]), axis=(0, 2))
    )
    assert clean < 1.5
    assert reported < 1.2 * clean
    assert unreported > 10


def settled_blocks(system: Modes, frequencies: np.ndarray, corner_hz: float) -> list[Block]:
    """Sine blocks long after the start of their bursts, with what still decays of each mode, in closed form.

    Every part is an exponential, which a coupling that has settled multiplies by s / (s + omega_c), and no more.
    """
    rng, rate, n = np.random.default_rng(6), 1000.0, 1024
    t = np.arange(n) / rate
    omega = 2 * np.pi * system.frequency_hz
    poles = -system.zeta * omega + 1j * omega * np.sqrt(1 - system.zeta**2)
    found = []
    for hz in frequencies:
        s = 2j * np.pi * hz
        gains = system.phi[:, 2] * s**2 / (s**2 + 2 * system.zeta * omega * s + omega**2)
        steady = 0.5 * gains @ system.phi
        decays = 0.05 * np.abs(steady).max() * rng.standard_normal((len(poles), 1)) * system.phi
        parts = [(s, steady), *zip(poles, decays, strict=True)]
        turned = [(p, a * p / (p + 2 * np.pi * corner_hz)) for p, a in parts]
        responses = sum(np.real(a[:, None] * np.exp(p * t)) for p, a in turned)
        samples = np.vstack([0.5 * np.cos(2 * np.pi * hz * t), responses])
        samples += rng.standard_normal(samples.shape) * np.array([6e-4, *[3e-3] * len(system.phi.T)])[:, None]
        found.append(block(f"sine_{hz:07.3f}", "sine", len(found), rate, samples, 3, frequency_hz=float(hz)))
    return found


def test_the_sine_model_is_that_of_dc_coupled_channels() -> None:
    # Three points distinguish three modes; five take four times as long to identify, and say the same.
    system = modes(np.random.default_rng(5), n_points=3)
    frequencies = np.array([5, 6, 7, 8, 30, 56, 58, 60, 62, 64, 120, 156, 160, 164, 168]) / 1.024

    def model(corner_hz: float, believed_hz: float) -> ModalModel:
        rig = coupled_rig(0.0, believed_hz, points=3)
        return identify_sine(
            to_signals_of(settled_blocks(system, frequencies, corner_hz), rig), rig, IdentificationOptions()
        )[0]

    clean = model(0.0, 0.0)
    assert apart(clean, model(CORNER_HZ, CORNER_HZ)) < 0.5
