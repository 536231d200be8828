"""Numbers of effects as coordinates of a fit."""

import numpy as np
import pytest

from modallab.twin.candidate import FreeNumber

RATIO = FreeNumber("zeta", "log", (0.04,), low=1e-3, high=0.4)


@pytest.mark.parametrize("value", [1.1e-3, 0.01, 0.04, 0.3, 0.39])
def test_a_coordinate_is_that_of_its_number(value: float) -> None:
    assert RATIO.value(RATIO.coordinate(value)) == pytest.approx(value, rel=1e-9)


def test_in_the_middle_of_its_range_a_positive_number_runs_by_its_logarithm() -> None:
    assert RATIO.coordinate(0.04) == np.log(0.04)
    assert FreeNumber("mass", "log", (0.1,)).coordinate(1e-9) == np.log(1e-9)


def test_a_number_at_an_end_of_its_range_still_has_a_slope() -> None:
    u = np.array([-60.0, -20.0, -8.0, -3.0, 0.0, 20.0, 60.0])
    values = [RATIO.value(float(v)) for v in u]
    assert values[0] >= 1e-3
    assert values[-1] <= 0.4
    slopes = [RATIO.value(float(v) + 1e-4) - RATIO.value(float(v)) for v in u]
    assert min(slopes) > 0


def test_a_number_that_is_held_stays() -> None:
    held = FreeNumber("k", "log", (2.0,), low=2.0, high=2.0)
    assert held.value(held.coordinate(5.0)) == 2.0
