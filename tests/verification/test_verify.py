"""Regenerated against measured: for the true model they are the same, block, filter and all."""

import functools
import json
from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.frf.estimate import convert_frf, group_by_point, impact_frf
from modallab.identification.impact import identify_impact
from modallab.identification.likelihood.hit_blocks import moves_before
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models, write_models
from modallab.signals.signals import to_signals_of
from modallab.verification.assessment import mismatch_warning
from modallab.verification.verify import frac, replayed_hit, synthesised_frf, verify_frf, verify_impact

BAND = (2.9, 400.0)


@functools.cache
def verified(noise=1e-4, seed=1):
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.impact_blocks(system, rng, points=(5, 3), hits=2, noise=noise, force_noise=noise)
    signals = to_signals_of(blocks, rig)
    model, fit = identify_impact(signals, rig, IdentificationOptions(band_hz=BAND))
    return system, model, verify_impact(model, fit, group_by_point(signals), rig)


def true_mobility(system, frequency_hz, drive):
    s = 2j * np.pi * frequency_hz
    w = 2 * np.pi * system.frequency_hz[:, None]
    return np.einsum(
        "mo,m,mk->ok", system.phi, system.phi[:, drive], s / (s**2 + 2 * system.zeta[:, None] * w * s + w**2)
    )


def test_the_right_model_regenerates_the_blocks_whatever_they_cut_off():
    _, _, found = verified()
    assert found.measured.quantity == found.regenerated.quantity == "mobility"
    assert found.frac.shape == (5, 2)
    assert found.frac.min() > 0.99999


def test_the_measured_mobility_itself_is_not_the_structures():
    system, _, found = verified()
    truth = true_mobility(system, found.measured.frequency_hz, 4)
    cross = np.abs(np.sum(found.measured.values[:, 0].conj() * truth, axis=1)) ** 2
    power = np.sum(np.abs(found.measured.values[:, 0]) ** 2, axis=1) * np.sum(np.abs(truth) ** 2, axis=1)
    assert np.all(cross / power < 0.97)


def test_the_untruncated_model_is_the_structures_own_mobility():
    system, _, found = verified()
    inside = found.untruncated.frequency_hz < 250
    truth = true_mobility(system, found.untruncated.frequency_hz[inside], 4)
    error = np.abs(found.untruncated.values[:, 0, inside] - truth).max()
    assert error < 0.01 * np.abs(truth).max()


def test_noise_lowers_frac():
    assert verified(noise=0.3)[2].frac.min() < verified()[2].frac.min()


def test_an_frf_made_from_the_model_agrees_with_it_inside_its_band():
    _, model, _ = verified()
    frf = synthesised_frf(model, np.linspace(1.0, 450.0, 600), "inertance")
    found = verify_frf(model, frf)
    np.testing.assert_allclose(found.frac, 1, rtol=1e-12)
    assert found.measured.frequency_hz.min() >= model.band_hz[0]
    assert found.measured.frequency_hz.max() <= model.band_hz[1]


def test_drift_near_0_hz_does_not_hide_that_measured_inertances_are_repeated():
    _, model, _ = verified()
    lines = np.linspace(3.0, 400.0, 600)
    frf = synthesised_frf(model, lines, "inertance")
    drift = 0.1 * np.abs(frf.values).max(axis=-1, keepdims=True) * (lines < 5.0)
    found = verify_frf(model, replace(frf, values=frf.values + drift))
    assert frac(found.measured.values, found.regenerated.values).min() < 0.9
    assert not mismatch_warning(model, found.frac)


@pytest.mark.parametrize(("quantity", "power"), [("mobility", 1), ("inertance", 2)])
def test_a_synthesised_frf_differentiates_the_receptance(quantity, power):
    _, model, _ = verified()
    f = np.linspace(5.0, 100.0, 20)
    expected = synthesised_frf(model, f, "receptance").values * (2j * np.pi * f) ** power
    np.testing.assert_allclose(synthesised_frf(model, f, quantity).values, expected)


NARROW = (60.0, 200.0)


@functools.cache
def of_a_narrow_band():
    rng = np.random.default_rng(3)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.impact_blocks(system, rng, points=(5, 3), hits=2, noise=1e-4, force_noise=1e-4)
    campaign = Campaign(rig=rig, blocks=tuple(blocks), source="made")
    return campaign, identify_campaign(campaign, IdentificationOptions(band_hz=NARROW), "impact")


def test_the_frac_of_a_narrow_band_is_that_of_the_written_model(tmp_path):
    campaign, result = of_a_narrow_band()
    write_models(tmp_path / "models.json", campaign, result)
    (model,) = read_models(tmp_path / "models.json")
    written = json.loads((tmp_path / "models.json").read_text())
    groups = group_by_point(to_signals_of(campaign.blocks, campaign.rig))
    moving = any(moves_before(s) for group in groups for s in group)
    again = [[replayed_hit(model, k, s, "inertance", moving=moving) for s in g] for k, g in enumerate(groups)]
    sides = [convert_frf(impact_frf(g, campaign.rig, NARROW), "mobility").values for g in (groups, again)]
    np.testing.assert_allclose(written["models"][0]["frac"], frac(*sides), atol=1e-6)
    own = synthesised_frf(model, impact_frf(groups, campaign.rig, NARROW).frequency_hz, "mobility").values
    np.testing.assert_allclose(written["frac_uncut"][0], frac(sides[0], own), atol=1e-6)


def test_a_model_that_does_not_repeat_the_records_says_so():
    _, result = of_a_narrow_band()
    model = result.identified[0].model
    assert mismatch_warning(model, np.full((5, 2), 0.95)) == ()
    poor = np.full((5, 2), 0.95)
    poor[2, 1] = 0.31
    (sentence,) = mismatch_warning(model, poor)
    assert "1 of the 10" in sentence
    assert "a03 driven at point 3 with 0.31" in sentence
