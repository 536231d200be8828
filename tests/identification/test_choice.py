"""What the operator says overrides the automatic selection; what is wrong with the model passes for no mode."""

import functools
from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.errors import IdentificationError
from modallab.identification.impact import identify_impact
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.prune import confidence_of_strength, least_strength, strength_of_modes
from modallab.signals.signals import to_signals_of


@functools.cache
def recorded():
    rng = np.random.default_rng(4)
    system, rig = bench.modes(rng), bench.rig(5)
    return system, rig, to_signals_of(bench.impact_blocks(system, rng, points=(5,), hits=3), rig)


@functools.cache
def identified():
    """All modes of the hits, and the fit."""
    _, rig, signals = recorded()
    return identify_impact(signals, rig, IdentificationOptions())


def test_a_dropped_mode_is_gone_and_the_others_stay():
    system, rig, signals = recorded()
    all_of_them = identified()[0]
    unwanted = float(system.frequency_hz[1])
    model = identify_impact(signals, rig, IdentificationOptions(drop_hz=(unwanted,)))[0]
    assert model.n_modes == all_of_them.n_modes - 1
    left = np.delete(all_of_them.frequency_hz, int(np.argmin(np.abs(all_of_them.frequency_hz - unwanted))))
    np.testing.assert_allclose(model.frequency_hz, left, rtol=1e-3)


def test_picked_modes_are_the_model():
    system, rig, signals = recorded()
    picked_hz = tuple(float(f) * 1.005 for f in system.frequency_hz[:3])
    model = identify_impact(
        signals, rig, IdentificationOptions(pick_hz=picked_hz, band_hz=(3.0, float(system.frequency_hz[2]) * 1.5))
    )[0]
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz[:3], rtol=1e-4)


@pytest.mark.parametrize("how", [{"drop_hz": (333.0,)}, {"pick_hz": (1.0,)}])
def test_a_frequency_without_a_mode_is_rejected_with_those_there_are(how):
    _, rig, signals = recorded()
    with pytest.raises(IdentificationError, match=r"there are .* Hz"):
        identify_impact(signals, rig, IdentificationOptions(**how))


@pytest.mark.thorough("identifies a recording that no model fits")
def test_a_chain_on_two_clocks_gives_no_more_modes_than_there_are():
    """Responses on a clock 1.5 % off the force's: poles that no structure has explain a part of it."""
    system, rig, signals = recorded()
    n = signals[0].force.size
    times = np.arange(n) * 1.015
    stretched = [
        replace(s, responses=np.stack([np.interp(times, np.arange(n), row) for row in s.responses])) for s in signals
    ]
    model = identify_impact([replace(s) for s in stretched], rig, IdentificationOptions())[0]
    near = [np.min(np.abs(system.frequency_hz * 1.015 / f - 1)) < 0.01 for f in model.frequency_hz]
    assert all(near)
    assert any("residual is" in note for note in model.notes)


def test_confidence_grows_with_the_strength_and_falls_with_the_misfit():
    fit = identified()[1]
    assert least_strength(fit, float("nan")) == least_strength(fit, 1.0) < least_strength(fit, 1.5)
    weak, strong = confidence_of_strength(np.array([6.0, 600.0]), least_strength(fit, 1.0))
    assert 0 < weak < 0.5 < strong < 1
    assert strength_of_modes(fit).max() > 100


def test_a_picked_mode_stays_what_it_is_among_all():
    system, rig, signals = recorded()
    every = identified()[0]
    one = identify_impact(signals, rig, IdentificationOptions(pick_hz=(float(system.frequency_hz[1]),)))[0]
    at = int(np.argmin(np.abs(every.frequency_hz - system.frequency_hz[1])))
    assert one.n_modes == 1
    assert abs(one.frequency_hz[0] - every.frequency_hz[at]) < every.frequency_sigma_hz[at]
    assert abs(one.damping_ratio[0] - every.damping_ratio[at]) < every.damping_sigma[at]
