"""What a rig's tolerances allow two FRFs of one structure to differ by."""

import numpy as np
import pytest

from modallab.cli.demo import demo_rig
from modallab.core.frf import Frf
from modallab.core.rig import Rig, Tolerance
from modallab.identification.selection.assumptions import CHANGE_LIMIT, AllowedDifference, linearity
from modallab.pipelines.assess import allowed_differences


@pytest.fixture(scope="module")
def rig() -> Rig:
    return demo_rig()


def test_a_rig_without_tolerances_of_assembly_allows_what_every_rig_does(rig: Rig) -> None:
    assert allowed_differences(rig, 800.0) == (AllowedDifference(), AllowedDifference())
    assert allowed_differences(rig.model_copy(update={"beam": None}), 800.0) == (
        AllowedDifference(),
        AllowedDifference(),
    )


def test_the_farther_off_a_hit_may_land_the_more_may_its_frf_differ(rig: Rig) -> None:
    usual = rig.model_copy(update={"tolerance": Tolerance.usual()})
    hits, places = allowed_differences(usual, 450.0)
    # k^4 = omega^2 rho A / EI = 7.99e6 rad^2/s^2 * 1.57 kg/m / 54.7 N m^2: k = 21.9 / m, and k times 2 mm is 4.4 %.
    assert hits.share == pytest.approx(3 * np.sqrt(2) * np.hypot(0.0438, 0.004), rel=0.01)
    assert places.share > hits.share
    assert "2 mm" in hits.why
    lower, _ = allowed_differences(usual, 450.0 / 4)
    assert lower.share == pytest.approx(hits.share / 2, rel=0.02)


@pytest.mark.parametrize(
    ("allowed", "holds"), [(AllowedDifference(), False), (AllowedDifference(0.2, "as hits may land off"), True)]
)
def test_a_verdict_says_why_more_is_allowed(allowed: AllowedDifference, holds: bool) -> None:
    hz = np.arange(1.0, 50.0)
    low = Frf(hz, np.ones((1, 1, hz.size), dtype=complex), "mobility", ("a",), (1,), (2,))
    high = Frf(hz, 1.1 * low.values, "mobility", ("a",), (1,), (2,))
    verdict = linearity(low, high, allowed)
    assert verdict.holds == holds
    assert ("as hits may land off" in verdict.words) == holds
    assert verdict.limit == max(CHANGE_LIMIT, allowed.share)
