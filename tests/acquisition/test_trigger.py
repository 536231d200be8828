"""The trigger is exact to the sample, whatever chunks the signal comes in."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from modallab.acquisition.procedures.trigger import Trigger

LEVEL, HYSTERESIS = 2.0, 1.0

signals = st.lists(st.sampled_from([-1.0, 0.0, 0.9, 1.0, 1.5, 2.0, 2.5, 9.0]), min_size=1, max_size=60)


def by_definition(signal: list[float]) -> int | None:
    low = False
    for n, value in enumerate(signal):
        if low and value >= LEVEL:
            return n
        low = low or value < LEVEL - HYSTERESIS
    return None


@given(signals, st.lists(st.integers(1, 20), min_size=1, max_size=60))
def test_the_same_sample_for_any_chunks(signal: list[float], chunks: list[int]) -> None:
    trigger, start, found = Trigger(LEVEL, HYSTERESIS), 0, None
    sizes = iter(chunks * 60)
    while start < len(signal) and found is None:
        chunk = np.array(signal[start : start + next(sizes)])
        at = trigger.scan(chunk)
        found = None if at is None else start + at
        start += len(chunk)
    assert found == by_definition(signal)


def test_a_force_that_is_high_from_the_start_must_fall_first() -> None:
    trigger = Trigger(LEVEL, HYSTERESIS)
    assert trigger.scan(np.array([5.0, 5.0, 1.5, 5.0])) is None
    assert trigger.scan(np.array([0.5, 5.0])) == 1
