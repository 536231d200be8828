"""A swept sine: a chirp whose block is as long as one likes. Modes against the closed form, and what few sweeps say."""

import functools

import modal_bench as bench
import numpy as np
import pytest
from scipy.signal import chirp

from modallab.core.block import Campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.averaged_frfs import TOO_FEW
from modallab.pipelines.identify import identify_campaign

RATE, SWEEP_S, FINER = 1000.0, 16.0, 4
BAND = IdentificationOptions(band_hz=(3.0, 75.0))


@functools.cache
def identified(sweeps: int, drift: float = 0.0):
    """Modes and the model of so many sweeps from 2 to 90 Hz, after one to settle; frequencies drift by turns."""
    rng = np.random.default_rng(3)
    system, n = bench.modes(rng), int(RATE * SWEEP_S)
    t = np.arange(n * FINER) / (RATE * FINER)
    force = np.tile(5 * chirp(t, 2.0, SWEEP_S, 90.0) * np.minimum(1, np.minimum(t, SWEEP_S - t) / 0.3), sweeps + 1)
    blocks = []
    for k in range(sweeps):
        here = bench.Modes(system.frequency_hz * (1 + drift * (-1) ** k), system.zeta, system.phi)
        answer = bench.respond(here, force, 5, RATE * FINER)
        both = bench.lowpass(np.vstack([force, answer]), FINER)[:, (k + 1) * n : (k + 2) * n]
        both[1:] += 1e-3 * both[1:].std() * rng.standard_normal(both[1:].shape)
        blocks.append(bench.block(f"sweep_{k}", "chirp", k, RATE, both, 5))
    campaign = Campaign(bench.rig(5), tuple(blocks), source="sweeps")
    return system, identify_campaign(campaign, BAND, None).identified[0].model


@pytest.mark.thorough("records and identifies sweeps")
def test_sweeps_give_the_modes() -> None:
    system, model = identified(4)
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz[:2], rtol=1e-5)
    np.testing.assert_allclose(model.damping_ratio, system.zeta[:2], rtol=2e-3)
    assert TOO_FEW not in model.notes


@pytest.mark.thorough("identifies three more sweeps")
def test_three_sweeps_that_differ_are_stated_as_uncertain_as_they_differ() -> None:
    system, model = identified(3, 2e-5)
    off = np.abs(model.frequency_hz - system.frequency_hz[:2])
    assert np.all(off < 3 * model.frequency_sigma_hz)
    assert np.all(model.frequency_sigma_hz > 1e-5 * model.frequency_hz)
    assert TOO_FEW not in model.notes


def test_of_two_sweeps_it_is_said_that_their_scatter_does_not_show() -> None:
    _, model = identified(2)
    assert TOO_FEW in model.notes
