"""Modes from responses alone: against the closed form of what answered the noise, with intervals that hold."""

import functools

import numpy as np
import pytest
from scipy.signal import lfilter

from modallab.cli import main
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.rig import Channel, Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.identification.response_only.covariances import covariances_by_band
from modallab.identification.response_only.half_spectra import HalfSpectra
from modallab.identification.response_only.looks import PLSCF
from modallab.identification.response_only.modes import response_modes
from modallab.identification.response_only.subspace import Subspace
from modallab.pipelines.model_file import read_models
from modallab.pipelines.response_only import identify_responses

F, ZETA = np.array([6.0, 21.0, 40.0]), np.array([0.02, 0.01, 0.008])
PHI = np.array([[1.0, 0.6, -0.4, 0.3], [0.5, -1.0, 0.2, 0.6], [-0.3, 0.4, 1.0, 0.7]])
RATE, SECONDS = 128.0, 200.0


@functools.cache
def responses(seed=0, seconds=SECONDS):
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    y = np.zeros((4, n))
    for f, zeta, phi in zip(F, ZETA, PHI, strict=True):
        w = 2 * np.pi * f
        z = np.exp(w * (-zeta + 1j * np.sqrt(1 - zeta**2)) / RATE)
        y += np.outer(phi, lfilter([1.0], [1, -2 * z.real, abs(z) ** 2], rng.standard_normal(n)) * abs(1 - z))
    return y + 1e-2 * rng.standard_normal(y.shape)


@functools.cache
def found(seed=0):
    return response_modes([responses(seed)], RATE, (3.0, 55.0))


def test_all_modes_and_no_other_are_found_with_shapes():
    modes = found()
    np.testing.assert_allclose(modes.frequency_hz, F, rtol=3e-3)
    np.testing.assert_allclose(modes.damping_ratio, ZETA, rtol=0.3)
    for shape, phi in zip(modes.shapes, PHI, strict=True):
        assert abs(np.vdot(shape, phi)) ** 2 > 0.99 * np.vdot(shape, shape).real * (phi @ phi)
        assert np.abs(shape).max() == pytest.approx(1)


@pytest.mark.thorough("identifies many recordings")
def test_the_sigmas_are_those_of_the_scatter():
    """Of eight seeds and three modes, each twice, 95 % would be 46 of 48; below 40 is one chance in a thousand."""
    held, f, sigma = 0, [], []
    for seed in range(8):
        modes = found(seed)
        assert modes.frequency_hz.size == F.size
        held += np.count_nonzero(np.abs(modes.frequency_hz - F) < 1.96 * modes.frequency_sigma_hz)
        held += np.count_nonzero(np.abs(modes.damping_ratio - ZETA) < 1.96 * modes.damping_sigma)
        f.append(modes.frequency_hz)
        sigma.append(modes.frequency_sigma_hz)
    assert held >= 40
    assert 0.6 < np.mean(np.std(f, axis=0) / np.mean(sigma, axis=0)) < 1.5


def test_what_a_segment_moves_is_the_derivative():
    """Against the difference of two identifications whose covariances differ a little."""
    rng = np.random.default_rng(1)
    lags = 20
    s = np.exp(2 * np.pi * F / RATE * (-ZETA + 1j))
    clean = np.einsum("m,ml,mo,mp->lop", [1.0, 0.8, 0.6], np.real(s[:, None] ** np.arange(1, lags + 1)), PHI, PHI)
    change = 1e-3 * rng.normal(size=(2, *clean.shape))
    change[1] = -change[0]
    first = Subspace(clean + change, RATE, 6).at(6)
    step = 1e-4
    ahead, back = (Subspace((clean + k * step * change[0])[None], RATE, 6).at(6) for k in (1, -1))
    np.testing.assert_allclose(first.moved[0], (ahead.poles - back.poles) / (2 * step), rtol=1e-3, atol=1e-7)
    shapes = (ahead.shapes - back.shapes) / (2 * step)
    np.testing.assert_allclose(first.shapes_moved[0], shapes, rtol=1e-3, atol=1e-6)


@pytest.mark.thorough("identifies by two methods")
def test_plscf_on_half_spectra_finds_what_ssi_finds():
    """Both see the same records, so that they differ by little more than either is off."""
    ours, known = response_modes([responses(1)], RATE, (3.0, 55.0), PLSCF), found(1)
    assert np.all(np.abs(ours.frequency_hz - known.frequency_hz) < 1.5 * known.frequency_sigma_hz)
    assert np.all(np.abs(ours.damping_ratio - known.damping_ratio) < 1.5 * known.damping_sigma)
    assert np.all(np.abs(ours.frequency_hz - F) < 3 * ours.frequency_sigma_hz)
    assert np.all(ours.frequency_sigma_hz < 2 * known.frequency_sigma_hz)
    for shape, phi in zip(ours.shapes, PHI, strict=True):
        assert abs(np.vdot(shape, phi)) ** 2 > 0.99 * np.vdot(shape, shape).real * (phi @ phi)


def test_a_sum_over_cut_off_decays_is_rational_at_its_own_lines():
    """Few lags of modes that hardly decay within them: without noise the poles are exact."""
    s = 2 * np.pi * F * (-ZETA + 1j * np.sqrt(1 - ZETA**2))
    decays = np.exp(s / RATE * np.arange(1, 49)[:, None])
    clean = np.einsum("m,lm,mo,mp->lop", [1.0, 0.8, 0.6], decays.real, PHI, PHI)
    poles = HalfSpectra(np.stack([clean, clean]), RATE, 12).at(6).poles
    for pole in s:
        assert np.abs(poles / pole - 1).min() < 1e-6


def test_bands_divide_the_range_without_a_gap():
    parts = list(covariances_by_band([responses()], RATE, (1.0, 55.0)))
    edges = [(b.low_hz, b.high_hz) for b in parts]
    assert edges[0][1] == pytest.approx(0.4 * RATE)
    assert [low for low, _ in edges[:-1]] == [high for _, high in edges[1:]]
    assert edges[-1][0] == 1.0


@pytest.mark.parametrize(
    ("records", "band", "error", "words"),
    [
        ([responses()[:, :200]], (3.0, 55.0), DataError, "too short"),
        ([responses(), responses()[:2]], (3.0, 55.0), DataError, "make no set-up"),
        ([responses()], (3.0, 80.0), DataError, "does not lie between 0 and half"),
        ([0 * responses()], (3.0, 55.0), DataError, "does not move"),
    ],
)
def test_what_cannot_be_identified_is_named(records, band, error, words):
    with pytest.raises(error, match=words):
        response_modes(records, RATE, band)


def test_noise_alone_has_no_modes():
    with pytest.raises(IdentificationError, match="stable and known"):
        response_modes([np.random.default_rng(3).standard_normal((4, 20000))], RATE, (3.0, 55.0))


@pytest.fixture(scope="module")
def campaign():
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [Channel(index=i, name=f"a{i}", quantity="acceleration", unit="m/s^2") for i in range(1, 5)]
    rig = Rig(name="any", model="unknown", channels=tuple(channels))
    n = 1000
    samples = np.vstack([np.random.default_rng(4).standard_normal(responses().shape[1]), responses()])
    blocks = tuple(
        Block(
            name=f"r{k}",
            test="random",
            order=k,
            rate_hz=RATE,
            samples=samples[:, k * n : (k + 1) * n],
            scale=np.ones(5),
            units=("N", *("m/s^2",) * 4),
            channels=tuple(c.name for c in channels),
            first_sample=k * n,
        )
        for k in range(samples.shape[1] // n)
    )
    return Campaign(rig, blocks)


def test_records_that_follow_each_other_are_one(campaign):
    (item,) = identify_responses(campaign, None, (3.0, 55.0)).identified
    model = item.model
    np.testing.assert_allclose(model.frequency_hz, F, rtol=3e-3)
    assert model.shapes is None
    assert type(model).model_validate_json(model.model_dump_json()).operating_shapes.shape == (3, 4)
    assert item.verification is None


def test_responses_alone_are_identified_at_the_terminal(campaign, tmp_path, capsys):
    write_campaign(campaign, tmp_path / "random.h5")
    command = ["identify", str(tmp_path / "random.h5"), "--response-only", "--band", "3", "55"]
    assert main([*command, "--json", str(tmp_path / "m.json")]) == 0
    assert "modal masses are not known" in capsys.readouterr().out.replace("\n", " ")
    (model,) = read_models(tmp_path / "m.json")
    assert model.method == "ssi_cov"
    assert model.operating_shapes is not None
    assert main([*command[:3], "plscf_spectra", *command[3:], "--report", str(tmp_path / "r.html")]) == 0
    page = (tmp_path / "r.html").read_text()
    assert "from the responses alone, with unscaled shapes" in page
    assert "each is 1 at its largest component" in page
    assert "pLSCF on half spectra" in page
    assert main([*command, "--pick", "21"]) == 2
    assert "cannot be combined with --pick" in capsys.readouterr().err
