"""A record is taken as the test that its force shows, whatever its label says."""

from dataclasses import replace

import drives
import modal_bench
import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.units import TESTS
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign, usable_blocks
from modallab.signals.drive_kind import drive_kind_of, is_hit

PAIRS = [(kind, label) for kind, right in drives.RIGHT.items() for label in TESTS if label not in right]


@pytest.mark.parametrize("kind", TESTS)
def test_each_kind_of_drive_is_recognised(kind):
    for seed in range(3):
        campaign = drives.campaign(kind, kind, seed)
        assert drive_kind_of([b.samples[0] for b in campaign.blocks], drives.RATE) == kind
        assert len(usable_blocks(campaign, campaign.blocks)[0]) == drives.BLOCKS


@pytest.mark.parametrize(("kind", "label"), PAIRS)
def test_no_test_is_identified_as_another(kind, label):
    with pytest.raises(DataError):
        identify_campaign(drives.campaign(kind, label, len(kind) + len(label)), IdentificationOptions())


def test_the_error_says_what_the_force_looks_like_and_what_to_do():
    with pytest.raises(DataError, match="labelled impact, but their force looks like bursts of random") as caught:
        identify_campaign(drives.campaign("burst-random", "impact", 1), IdentificationOptions())
    assert "--test burst-random" in str(caught.value)


def test_one_record_of_another_kind_among_many_is_left_out_with_a_note():
    good = drives.campaign("impact", "impact", 2)
    odd = replace(drives.campaign("chirp", "impact", 2).blocks[1], name="odd")
    kept, _, (note,) = usable_blocks(good, (*good.blocks[:3], odd))
    assert len(kept) == 3
    assert odd.name in note


@pytest.mark.parametrize("apart", [0.05, 0.2])
def test_a_double_hit_is_a_hit(apart):
    t = np.arange(2048) / 2000
    force = np.where(np.abs(t - 0.1) < 0.002, 50.0, 0.0) + np.where(np.abs(t - 0.1 - apart) < 0.002, 30.0, 0.0)
    assert is_hit(force)


@pytest.mark.parametrize("kind", ["multisine", "schroeder", "stepped-sine", "chirp"])
def test_whatever_every_block_repeats_is_a_periodic_drive_and_a_sweep_is_said_to_be_one(kind):
    periodic = drives.campaign(kind, "pseudo-random", 3)
    kept, _, notes = usable_blocks(periodic, periodic.blocks)
    assert len(kept) == drives.BLOCKS
    assert any("chirp" in note for note in notes) == (kind in ("chirp", "schroeder"))


def test_waves_of_two_periods_each_are_periodic():
    rng = np.random.default_rng(4)
    waves = [rng.standard_normal(512) for _ in range(4)]
    assert drive_kind_of([w for wave in waves for w in (wave, wave)], 512.0) == "pseudo-random"
    assert drive_kind_of([*waves, *rng.standard_normal((4, 512))], 512.0) == "random"


def test_a_force_that_is_let_go_is_named():
    forces = [b.samples[0] for b in drives.campaign("release", "burst-random", 4).blocks]
    assert drive_kind_of(forces, drives.RATE) == "release"
    assert drive_kind_of([-f for f in forces], drives.RATE) == "release"


def test_the_same_course_in_other_sizes_is_not_periodic():
    forces = [b.samples[0] for b in drives.campaign("pseudo-random", "pseudo-random", 4).blocks]
    assert drive_kind_of(forces, drives.RATE) == "pseudo-random"
    assert drive_kind_of([f * (1 + k) for k, f in enumerate(forces)], drives.RATE) == "random"


def test_lines_that_a_multisine_leaves_out_hold_no_frf_and_no_mode():
    # The lowest mode lies below the lowest line of this drive; a line beside it that only holds noise made a mode.
    seed = 1018
    found = (
        identify_campaign(drives.campaign("multisine", "pseudo-random", seed), IdentificationOptions())
        .identified[0]
        .model
    )
    true = modal_bench.modes(np.random.default_rng(seed)).frequency_hz[1:]
    np.testing.assert_allclose(found.frequency_hz, true, rtol=1e-4)
