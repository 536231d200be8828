"""What squares above the noise count for, between explanations of one campaign."""

import numpy as np
import pytest

from modallab.gap.inference.evidence import RecordsFloor, likelihood, probabilities_of
from modallab.gap.inference.settings import DEFAULT

MODES = 7
NUMBERS = 3 * MODES


def difference(costs: tuple[float, float], floor: RecordsFloor) -> float:
    first, second = likelihood(np.array(costs), floor)
    return float(second - first)


def test_near_the_noise_of_an_exact_model_squares_count_one_by_one():
    exact = RecordsFloor(least=2e4, above=0.0, expected=1.0, numbers=NUMBERS)
    assert difference((2e4, 2e4 + 0.1), exact) == pytest.approx(0.1, rel=0.01)


def test_far_above_what_a_wrong_model_leaves_only_the_ratio_counts():
    near, far = (RecordsFloor(least=a, above=a, expected=1e4, numbers=NUMBERS) for a in (1e9, 1e11))
    assert difference((1e9, 3e9), near) == pytest.approx(difference((1e11, 3e11), far), rel=1e-3)
    assert difference((1e9, 3e9), near) == pytest.approx((NUMBERS + 1) * np.log(3), rel=1e-3)


def test_no_effect_is_worth_its_price_that_takes_away_what_a_model_is_expected_to_leave_of_one_number():
    floor = RecordsFloor(least=2e4, above=0.0, expected=2e4, numbers=NUMBERS)
    assert difference((2e4, 2e4 + 0.7 * floor.expected), floor) < DEFAULT.effect_price
    assert difference((2e4, 2e4 + 2 * floor.expected), floor) > DEFAULT.effect_price


def test_probabilities_are_those_of_all_explanations_together():
    one, two = probabilities_of(np.array([5.0, 5.0 + DEFAULT.effect_price]))
    assert one / two == pytest.approx(np.exp(DEFAULT.effect_price / 2))
    assert one + two == pytest.approx(1.0)
