"""Every estimator finds the modes of a closed-form system, and from each the search ends at the same place."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest
from test_plscf import frf
from test_repeated_roots import _frf, _rig

from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.identification.estimate import estimate_poles
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign

METHODS = ("plscf", "era", "circle", "peak")
FREQUENCY, ZETA = np.array([12.0, 25.0, 41.0, 70.0]), np.array([0.010, 0.008, 0.006, 0.005])
PHI = np.random.default_rng(0).standard_normal((4, 6))
LINES = np.arange(1, 1601) * 0.05


def near(poles, hz):
    return poles[np.argmin(np.abs(np.abs(poles) / (2 * np.pi) - hz))]


@pytest.mark.parametrize(("method", "off"), [("plscf", 1e-6), ("era", 0.02), ("circle", 0.01), ("peak", 0.05)])
def test_poles_of_clean_frfs_are_found_by_every_estimator(method, off):
    found = estimate_poles(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES), method).poles
    for hz, zeta in zip(FREQUENCY, ZETA, strict=True):
        pole = near(found, hz)
        assert abs(pole) / (2 * np.pi) == pytest.approx(hz, rel=2e-3)
        assert -pole.real / abs(pole) == pytest.approx(zeta, rel=off)


@pytest.mark.parametrize("method", ["circle", "peak"])
def test_the_artificial_damping_is_taken_off_again(method):
    sigma = 0.7
    omega = 2 * np.pi * FREQUENCY[:, None]
    s = sigma + 2j * np.pi * LINES
    receptance = 1 / (s**2 + 2 * ZETA[:, None] * omega * s + omega**2)
    values = np.einsum("mo,mi,mk->oik", PHI, PHI[:, [0, 3]], receptance)
    shifted = replace(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES), values=values, damping_shift=sigma)
    found = estimate_poles(shifted, method).poles
    for hz, zeta in zip(FREQUENCY, ZETA, strict=True):
        assert near(found, hz).real == pytest.approx(-zeta * 2 * np.pi * hz, abs=0.3 * sigma)


@pytest.mark.parametrize("method", METHODS)
def test_the_search_ends_at_the_same_model_from_every_estimator(method):
    truth, zeta = [12.0, 25.0, 41.0, 70.0, 88.0, 104.0], [0.005] * 6
    case = _frf(truth, zeta)
    usual, _ = identify_frf(case, _rig(), IdentificationOptions())
    other, _ = identify_frf(case, _rig(), IdentificationOptions(method=method, refine=True))
    assert other.method == method
    assert np.all(np.abs(other.frequency_hz - usual.frequency_hz) < 0.2 * usual.frequency_sigma_hz)
    assert np.all(np.abs(other.damping_ratio - usual.damping_ratio) < 0.2 * usual.damping_sigma)
    np.testing.assert_allclose(other.damping_sigma, usual.damping_sigma, rtol=0.01)


@pytest.mark.parametrize("method", ["plscf", "era", "circle"])
def test_unrefined_poles_are_the_estimators_own_and_claim_no_uncertainty(method):
    case = _frf([12.0, 25.0, 41.0, 70.0], [0.005] * 4)
    model, _ = identify_frf(case, _rig(), IdentificationOptions(method=method, refine=False))
    poles = estimate_poles(case, method).poles
    np.testing.assert_allclose(model.frequency_hz, np.sort(np.abs(poles)) / (2 * np.pi), rtol=1e-9)
    assert np.isnan(model.frequency_sigma_hz).all()
    assert np.isnan(model.modal_constant_sigma).all()
    assert any("not refined" in note for note in model.notes)


@pytest.mark.parametrize("method", METHODS)
def test_hits_are_identified_from_every_estimator(method):
    rng = np.random.default_rng(4)
    system = bench.modes(rng)
    campaign = Campaign(rig=bench.rig(5), blocks=tuple(bench.impact_blocks(system, rng, hits=2)))
    found = identify_campaign(campaign, IdentificationOptions(method=method, refine=True)).identified[0]
    assert found.model.method == method
    assert found.verification is not None
    np.testing.assert_allclose(found.model.frequency_hz, system.frequency_hz, rtol=1e-3)
    assert np.all(np.abs(found.model.damping_ratio - system.zeta) < 5 * found.model.damping_sigma)


def test_what_an_estimator_cannot_take_is_rejected():
    case = frf(FREQUENCY, ZETA, PHI, [0, 3], LINES)
    for method in METHODS:
        with pytest.raises(DataError):
            estimate_poles(replace(case, values=case.values * np.nan), method)
    with pytest.raises(IdentificationError, match="order 0"):
        estimate_poles(case, "plscf", 0)
    with pytest.raises(DataError, match="uneven"):
        estimate_poles(replace(case, frequency_hz=np.geomspace(1, 80, LINES.size)), "era")
