"""Hits between which the structure drifts: the stated uncertainty holds what the noise does not explain."""

import functools
from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.identification.impact import identify_impact
from modallab.identification.likelihood.hit_scatter import factors_by_scatter, hit_pulls
from modallab.identification.options import Options
from modallab.signals.signals import to_signals_of

HITS = 8
BAND = Options(band_hz=(2.9, 75.0))


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
    pulls, shares = (part[:, 2 * best] for part in hit_pulls(fit))
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
    far, close = factors_by_scatter(fit, 1.0)[:, 1], factors_by_scatter(fit, 10.0)[:, 1]
    assert np.all(close <= far)
    assert np.any(close[far == 1] < 1)
    assert np.all(close >= 0.1)
