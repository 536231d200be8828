"""More points and more hits never lose a mode: what a part of the records shows, all of them show."""

import functools
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import modal_bench as bench
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.plan import ImpactPlan
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.impact import identify_impact
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.signals.signals import to_signals_of

DATA = Path(__file__).parents[1] / "data"
POINTS, HITS = 10, 3


@functools.cache
def recorded(seed):
    """Seven modes of a beam, the lowest at a hundredth of the band, struck at ten points."""
    rng = np.random.default_rng(seed)
    system = bench.modes(rng, n_modes=7, n_points=POINTS, first_hz=4.75)
    rig = bench.rig(POINTS)
    blocks = bench.impact_blocks(system, rng, points=tuple(range(1, POINTS + 1)), hits=HITS)
    return system, rig, to_signals_of(blocks, rig)


def missed(frequency_hz, found_hz):
    return [f for f in frequency_hz if np.min(np.abs(found_hz / f - 1)) > 1e-3]


@pytest.mark.thorough("identifies recordings at up to ten points")
@settings(max_examples=4, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2), points=st.sets(st.integers(1, POINTS), min_size=1), hits=st.integers(1, HITS))
def test_every_plan_finds_the_modes_of_its_band(seed, points, hits):
    system, rig, signals = recorded(seed)
    struck = groupby((s for s in signals if s.block.drive_point in points), key=lambda s: s.block.drive_point)
    model = identify_impact([s for _, of in struck for s in list(of)[:hits]], rig, IdentificationOptions())[0]
    inside = system.frequency_hz[system.frequency_hz < 0.98 * model.band_hz[1]]
    assert not missed(inside, model.frequency_hz)
    assert model.n_modes <= len(system.frequency_hz)


@pytest.mark.thorough("records and identifies twenty hits on the simulated bench")
def test_ten_points_on_a_bench_as_built_find_what_three_of_them_find():
    import modallab as ml

    plan = ImpactPlan(points=tuple(range(10, 0, -1)), hits=2)
    whole = ml.simulate(seed=1, tolerances="usual", plan=plan, progress=False).campaign
    part = replace(whole, blocks=tuple(b for b in whole.blocks if b.drive_point in (10, 7, 3)))
    few, all_of_them = (identify_campaign(c, IdentificationOptions()).identified[0] for c in (part, whole))
    assert few.model.n_modes == 7
    assert not missed(few.model.frequency_hz, all_of_them.model.frequency_hz)
    assert not any("does not repeat" in note for note in all_of_them.model.notes)


def test_a_weak_mode_beside_a_strong_one_is_found_in_hits_that_differ() -> None:
    # Measured hits; beside 3669 Hz no order of the estimator shows 3665 Hz.
    hits = read_campaign(DATA / "hammer_5hits.h5", read_rig(DATA / "hammer_rig.yaml"))
    model = identify_campaign(hits, IdentificationOptions(band_hz=(3500, 3850))).identified[0].model
    np.testing.assert_allclose(model.frequency_hz, (3665.0, 3668.9, 3689.7), atol=0.3)
