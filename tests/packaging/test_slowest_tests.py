"""A run in which a few tests take most of the time is found by the times of its tests, fixtures included."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Literal

import pytest
from slowest_tests import SlowestTests

When = Literal["setup", "call", "teardown"]


def timed(seconds: Mapping[str, Mapping[When, float]]) -> SlowestTests:
    found = SlowestTests(Fraction(1, 3))
    for name, parts in seconds.items():
        for when, duration in parts.items():
            report = pytest.TestReport(name, ("", 0, name), {}, "passed", None, when, duration=duration)
            found.pytest_runtest_logreport(report)
    return found


EVEN: dict[str, dict[When, float]] = {f"test_{n}": {"call": 1.0} for n in range(100)}


def test_tests_of_one_length_are_even() -> None:
    found = timed(EVEN)
    assert (found.total_s, found.slowest_s, found.uneven) == (100.0, 20.0, False)


@pytest.mark.parametrize("when", ["setup", "call", "teardown"])
def test_one_that_takes_most_is_too_much_whatever_part_of_it_does(when: When) -> None:
    found = timed({**EVEN, "test_0": {"call": 1.0} | {when: 60.0}})
    assert found.uneven
    assert found.total_s == pytest.approx(sum(found.seconds.values()))


def test_up_to_the_share_is_even() -> None:
    seconds: dict[str, dict[When, float]] = {f"test_{n}": {"call": 2.0 if n < 20 else 1.0} for n in range(100)}
    assert not timed(seconds).uneven
    seconds["test_0"] = {"call": 2.1}
    assert timed(seconds).uneven
