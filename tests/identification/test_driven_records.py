"""Records of a random force with noise on the force channel, against the closed form of what made them."""

import numpy as np
import pytest

from modallab.core.block import Block, Campaign
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.frf.joined import RecordSpectra
from modallab.identification.frf_model import identify_frf
from modallab.identification.likelihood.driven_records import DrivenFit, DrivenModel
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign

RATE, N = 256.0, 256 * 40
HZ, ZETA = np.array([30.0, 70.0]), np.array([0.01, 0.008])
PHI = np.array([[1.0, 0.8], [0.6, -0.9], [-0.5, 0.4]])
OUT_OF_95 = 1.96


def driven(noise: float, rng: np.random.Generator, seconds: int, top_hz: float, outputs: int = 3) -> RecordSpectra:
    """One record from 10 Hz on, with noise on the force channel and 0.3 % of noise on the responses."""
    n = round(RATE * seconds)
    omega, w = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE), 2 * np.pi * HZ[:, None]
    force = rng.normal(size=n)
    mode = -(omega**2) / (w**2 - omega**2 + 2j * ZETA[:, None] * w * omega)
    y = np.fft.irfft((PHI * PHI[0]) @ mode * np.fft.rfft(force), n)[:outputs]
    y += 3e-3 * y.std() * rng.normal(size=y.shape)
    lines = np.arange(10 * seconds, int(top_hz * seconds) + 1)
    spectra = (np.fft.rfft(x)[None, :, lines] for x in (force[None] + noise * rng.normal(size=(1, n)), y))
    return RecordSpectra(lines / seconds, n, RATE, *spectra)


def fitted(noise: float, seed: int, estimator: str, outputs: int = 3) -> tuple[DrivenModel, DrivenFit]:
    """A search from poles and residues that are a little off."""
    rng, w = np.random.default_rng(seed), 2 * np.pi * HZ
    records = driven(noise, rng, 40, 99.99, outputs)
    near, zeta = w * (1 + 1e-4 * rng.normal(size=2)), ZETA * 1.03
    start = np.zeros((7, outputs))
    start[1:4:2] = -(PHI[:outputs] * PHI[0] / (2 * w)).T
    fit = DrivenFit(records, (-2, 0, 2), 2, estimator)
    return fit.search(near, zeta, start), fit


def off(found: DrivenModel) -> np.ndarray:
    """Frequencies, damping ratios and drive-point constants: how many sigmas they are off."""
    sigma, modes = np.sqrt(np.diag(found.covariance)), 2
    scale = 2 * found.omega * np.sqrt(1 - found.zeta**2)
    poles = (found.omega - 2 * np.pi * HZ) / sigma[: 2 * modes : 2], (found.zeta - ZETA) / sigma[1 : 2 * modes : 2]
    constants = -scale * found.coefficients[1:4:2, 0]
    return np.concatenate([*poles, (constants - PHI[0] ** 2) / (scale * sigma[2 * modes + 1 : 2 * modes + 4 : 2])])


@pytest.mark.parametrize("outputs", [1, 3])
def test_the_power_of_noise_on_the_force_is_found_within_a_tenth_even_from_one_response(outputs: int) -> None:
    found, fit = fitted(0.1, 1, "H2", outputs)
    assert 1 - fit.true_share(found.force_noise).mean() == pytest.approx(0.1**2 / 1.01, rel=0.1)


def test_h1_is_low_by_the_power_of_the_noise_and_h2_is_not() -> None:
    h1, h2 = (fitted(0.2, 2, e)[0].coefficients[1:4:2] for e in ("H1", "H2"))
    np.testing.assert_allclose(h1 / h2, 1 / 1.04, rtol=5e-3)


@pytest.mark.thorough("fits twenty records")
def test_intervals_hold_what_is_true() -> None:
    within = np.mean([np.abs(off(fitted(0.1, seed, "H2")[0])) < OUT_OF_95 for seed in range(20)])
    assert 0.88 < within < 0.99


def test_a_pole_that_the_records_move_out_of_the_band_is_no_mode() -> None:
    # The mode at 70 Hz lies at the band's end: of one short record its FRFs may read it inside, and the record outside.
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=i, name=f"a{i}", quantity="acceleration", unit="m/s^2") for i in (1, 2, 3)]
    rig, options, moved_out = Rig(name="short", model="unknown", channels=tuple(channels)), IdentificationOptions(), 0
    for seed in range(8):
        records = driven(0.1, np.random.default_rng(seed), 8, 70.0)
        values = records.response[0] / records.force[0]
        frf = Frf(records.frequency_hz, values[:, None], "inertance", ("a1", "a2", "a3"), (1, 2, 3), (1,))
        by_frf, by_records = (identify_frf(frf, rig, options, *r)[0].frequency_hz for r in ((), (records,)))
        np.testing.assert_allclose(by_records, HZ[: len(by_records)], rtol=3e-3)
        assert by_records.max() <= records.frequency_hz[-1]
        moved_out += len(by_frf) > len(by_records)
    assert moved_out


def record(noise: float, seed: int) -> Campaign:
    """One response at the driven point, as exact as its noise of 0.1 %."""
    rng, omega, w = np.random.default_rng(seed), 2 * np.pi * np.fft.rfftfreq(N, 1 / RATE), 2 * np.pi * HZ[:, None]
    force = rng.normal(size=N)
    mode = -(omega**2) / (w**2 - omega**2 + 2j * ZETA[:, None] * w * omega)
    y = np.fft.irfft(PHI[0] ** 2 @ mode * np.fft.rfft(force), N)
    samples = np.stack([force + noise * rng.normal(size=N), y + 1e-3 * y.std() * rng.normal(size=N)])
    channels = (
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1),
    )
    rig = Rig(name="noisy force", model="unknown", points=(Point(id=1, x_m=0.0),), channels=channels)
    block = Block("run", "random", 0, RATE, samples, np.ones(2), ("N", "m/s^2"), ("force", "a1"), drive_point=1)
    return Campaign(rig, (block,))


@pytest.mark.thorough("identifies a record twice")
@pytest.mark.parametrize("how", ["H1", "H2"])
def test_the_interval_of_a_modal_constant_holds_the_bias_of_either_estimator(how: str) -> None:
    (found,) = identify_campaign(record(0.2, 3), IdentificationOptions(frf="H1" if how == "H1" else "H2")).identified
    model = found.model
    near = [int(np.argmin(np.abs(model.frequency_hz - hz))) for hz in HZ]
    parts = model.modal_constant_part_sigma
    assert parts is not None
    away = np.abs(model.modal_constants[near, 0, 0].real - PHI[0] ** 2) / parts[near, 0, 0].real
    assert (away < 2.5).all()
    # A constant is known no better than the two biases that are as likely: 0 and 0.04 / 1.04.
    assert (parts[near, 0, 0].real > 0.02 * PHI[0] ** 2).all()
