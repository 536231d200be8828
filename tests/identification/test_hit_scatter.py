"""Hits between which the structure drifts: the stated uncertainty holds what the noise does not explain."""

import functools
from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest
from scipy.optimize import curve_fit

from modallab.identification.impact import identify_impact
from modallab.identification.likelihood.even_residual import is_even
from modallab.identification.likelihood.hit_scatter import decay_bias, factors_by_scatter, hit_influences
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import to_signals_of

HITS = 8
BAND = IdentificationOptions(band_hz=(2.9, 75.0))


@functools.cache
def identified(spread: float, seed: int = 1, hits: int = HITS):
    """Model, fit and the shift of each hit's frequencies, relative and the same in all modes."""
    rng = np.random.default_rng(seed)
    system = bench.modes(rng)
    shift = spread * rng.standard_normal(hits)
    blocks = []
    for k in range(hits):
        here = replace(system, frequency_hz=system.frequency_hz * (1 + shift[k]))
        (block,) = bench.impact_blocks(here, rng, hits=1)
        blocks.append(replace(block, name=f"hit_{k}", order=k))
    rig = bench.rig(5)
    model, fit = identify_impact(to_signals_of(blocks, rig), rig, BAND)
    return model, fit, shift


def test_the_sigma_is_that_of_the_hits_mean_where_they_drift():
    model, fit, shift = identified(3e-4)
    expected = np.std(shift, ddof=1) / np.sqrt(HITS)
    best = np.argmin(model.frequency_sigma_hz / model.frequency_hz)
    assert model.frequency_sigma_hz[best] / model.frequency_hz[best] == pytest.approx(1.2 * expected, rel=0.3)
    assert fit.by_scatter is not None
    assert np.all(fit.by_scatter[: model.n_modes, 1] < 3)
    assert "shift from hit to hit by up to" in " ".join(model.notes)


def test_each_hit_pulls_by_its_own_shift():
    model, fit, shift = identified(3e-4)
    best = int(np.argmax(fit.by_scatter[: model.n_modes, 0]))
    pulls, shares = (part[:, 2 * best] for part in hit_influences(fit))
    expected = shares * (shift - shares @ shift) * fit.point.parameters.omega[best]
    assert np.corrcoef(pulls, expected)[0, 1] > 0.95
    assert shares.sum() == pytest.approx(1)
    assert abs(pulls.sum()) < 0.1 * np.abs(pulls).sum()


@pytest.mark.parametrize("seed", range(3))
def test_hits_on_a_structure_that_stays_change_no_sigma(seed):
    model, fit, _ = identified(0.0, seed)
    # A pole beyond the band stands for many, and has a prior besides.
    np.testing.assert_allclose(fit.by_scatter[: model.n_modes], 1, atol=0.1)
    assert not any("shift from hit to hit" in note for note in model.notes)


def test_few_hits_say_nothing_of_their_scatter():
    _, fit, _ = identified(3e-4, hits=3)
    assert np.all(factors_by_scatter(fit, 1.0) == 1)


def test_what_the_misfit_does_not_touch_is_known_by_its_scatter():
    """The drift of the frequencies raises the residual, but moves no damping: its sigma comes down towards noise's."""
    _, fit, _ = identified(3e-4)
    damping = factors_by_scatter(fit, 1.0)[:, 1]
    assert np.any(damping < 1)
    assert np.all(damping > 0.05)


@pytest.mark.thorough("identifies many recordings")
def test_the_residual_is_even_where_nothing_drifts_and_uneven_where_the_frequencies_do():
    assert all(is_even(identified(0.0, seed)[1]) for seed in range(3))
    assert not is_even(identified(3e-5)[1])


@pytest.mark.thorough("identifies many recordings")
@pytest.mark.parametrize("spread", [3e-5, 3e-4])
def test_damping_is_off_by_what_is_stated_though_the_frequencies_drift(spread):
    """The resonances of the mean are wider, which no scatter shows; the sigma holds that as well."""
    off = []
    for seed in range(4):
        model, _, _ = identified(spread, seed)
        true = bench.modes(np.random.default_rng(seed)).zeta[:2]
        off.append((model.damping_ratio[:2] - true) / model.damping_sigma[:2])
    assert np.abs(off).max() < 3
    assert 0.3 < np.sqrt(np.mean(np.square(off))) < 1.5


def test_scattered_frequencies_feign_a_faster_decay():
    """By the closed forms of a long block and of a short one, and by the mean of many decays itself."""
    assert decay_bias(np.array([50.0]), 1.0) == pytest.approx(1 / 50, rel=0.08)
    assert decay_bias(np.array([0.01]), 2.0) == pytest.approx(1.0, rel=0.02)
    t, shifts = np.linspace(0, 1.0, 2000), np.array([-0.3, 0.3])
    mean = np.mean(np.exp(-2.0 * t + 1j * shifts[:, None] * t), axis=0).real
    (amplitude, decay), _ = curve_fit(lambda x, b, a: b * np.exp(-a * x), t, mean, (1.0, 2.0))
    assert amplitude == pytest.approx(1, abs=0.02)
    assert decay - 2.0 == pytest.approx(0.09 * decay_bias(np.array([2.0]), 1.0)[0], rel=0.03)
