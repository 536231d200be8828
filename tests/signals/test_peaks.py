"""Prominent peaks are those that SciPy finds."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from modallab.signals.peaks import prominent_peaks


@pytest.mark.parametrize("digits", [12, 0])
@pytest.mark.parametrize("prominence", [0.0, 1.0, 2.5])
def test_peaks_are_scipys_flat_tops_as_well(digits: int, prominence: float) -> None:
    draw = np.random.default_rng(1)
    for _ in range(20):
        curve = np.round(draw.normal(size=int(draw.integers(1, 400))).cumsum(), digits)
        np.testing.assert_array_equal(prominent_peaks(curve, prominence), find_peaks(curve, prominence=prominence)[0])


@pytest.mark.parametrize("curve", [[], [1.0], [1.0, 2.0], [2.0, 2.0, 2.0], [0.0, 1.0, 2.0], [2.0, 1.0, 0.0]])
def test_ends_and_level_ground_are_no_peaks(curve: list[float]) -> None:
    assert prominent_peaks(np.array(curve), 0.0).size == 0


def test_a_peak_stands_out_of_the_higher_of_the_grounds_beside_it() -> None:
    curve = np.array([0.0, 5.0, 3.0, 4.0, 1.0, 9.0, 0.0])
    assert prominent_peaks(curve, 1.0).tolist() == [1, 3, 5]
    assert prominent_peaks(curve, 1.5).tolist() == [1, 5]
    assert prominent_peaks(curve, 4.5).tolist() == [5]
