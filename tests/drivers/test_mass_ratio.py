"""The rigid-mass ratio before and after a test."""

from datetime import date
from pathlib import Path

import numpy as np
import pytest

from modallab.commissioning.calibrate import measure_mass_ratio
from modallab.core.errors import FormatError
from modallab.core.hardware import MassRatio, judge_mass_ratios
from modallab.core.rig import Rig
from modallab.formats.rig.mass_ratios_file import FILE, add_mass_ratio, read_mass_ratios

RNG = np.random.default_rng(2)
MASS_KG = 1.2


def struck(rig: Rig, force_gain: float) -> np.ndarray:
    """Volts of a free mass that is struck, with a force transducer that reads `force_gain` of the force."""
    acceleration = RNG.standard_normal(4000)
    volts = 1e-4 * RNG.standard_normal((len(rig.channels), 4000))
    volts[0] += force_gain * MASS_KG * acceleration * rig.channels[0].sensitivity("impact")
    volts[1] += acceleration * rig.channels[1].sensitivity("impact")
    return volts


def ratio(rig: Rig, gain: float, when: str) -> MassRatio:
    return measure_mass_ratio(rig, struck(rig, gain), rig.channels[1], MASS_KG, when, date(2026, 2, 3))


def test_a_right_chain_has_the_ratio_1(rig: Rig):
    found = ratio(rig, 1.0, "before")
    assert abs(found.ratio - 1) < max(5 * found.sigma, 1e-3) < 0.01


@pytest.mark.parametrize(
    ("before", "after", "within"),
    [(1.0, 1.005, [True, True, True]), (1.0, 0.98, [True, True, False]), (1.08, 1.08, [False, False, True])],
)
def test_ratio_and_drift_are_judged_against_their_limits(rig: Rig, before: float, after: float, within: list[bool]):
    found = judge_mass_ratios([ratio(rig, before, "before"), ratio(rig, after, "after")])
    assert [one.within for one in found] == within


def test_ratios_are_kept_beside_the_campaign(rig: Rig, tmp_path: Path):
    assert read_mass_ratios(tmp_path) == ()
    first = ratio(rig, 1.0, "before")
    add_mass_ratio(tmp_path, first)
    assert len(add_mass_ratio(tmp_path, ratio(rig, 1.0, "after"))) == 2
    assert read_mass_ratios(tmp_path)[0] == first
    (tmp_path / FILE).write_text("- {ratio: 1}\n")
    with pytest.raises(FormatError, match="rigid-mass ratios"):
        read_mass_ratios(tmp_path)
