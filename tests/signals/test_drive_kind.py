"""A record is taken as the test that its force shows, whatever its label says."""

from dataclasses import replace

import drives
import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.units import TESTS
from modallab.identification.options import Options
from modallab.pipelines.identify import identify_campaign, usable
from modallab.signals.drive_kind import is_hit, looks_like

PAIRS = [(kind, label) for kind in TESTS for label in TESTS if kind != label]


@pytest.mark.parametrize("kind", TESTS)
def test_each_kind_of_drive_is_recognised(kind):
    for seed in range(3):
        campaign = drives.campaign(kind, kind, seed)
        assert looks_like([b.samples[0] for b in campaign.blocks], drives.RATE) == kind
        assert len(usable(campaign, campaign.blocks)[0]) == drives.BLOCKS


@pytest.mark.parametrize(("kind", "label"), PAIRS)
def test_no_test_is_identified_as_another(kind, label):
    with pytest.raises(DataError):
        identify_campaign(drives.campaign(kind, label, len(kind) + len(label)), Options())


def test_the_error_says_what_the_force_looks_like_and_what_to_do():
    with pytest.raises(DataError, match="labelled impact, but their force looks like bursts of random") as caught:
        identify_campaign(drives.campaign("burst-random", "impact", 1), Options())
    assert "--test burst-random" in str(caught.value)


def test_one_record_of_another_kind_among_many_is_left_out_with_a_note():
    good = drives.campaign("impact", "impact", 2)
    odd = replace(drives.campaign("chirp", "impact", 2).blocks[1], name="odd")
    kept, (note,) = usable(good, (*good.blocks[:3], odd))
    assert len(kept) == 3
    assert odd.name in note


@pytest.mark.parametrize("apart", [0.05, 0.2])
def test_a_double_hit_is_a_hit(apart):
    t = np.arange(2048) / 2000
    force = np.where(np.abs(t - 0.1) < 0.002, 50.0, 0.0) + np.where(np.abs(t - 0.1 - apart) < 0.002, 30.0, 0.0)
    assert is_hit(force)
