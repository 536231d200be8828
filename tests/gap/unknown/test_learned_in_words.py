"""Learned elements in words: every number that is given is said, in the unit that a reader expects."""

import pytest

from modallab.core.effect import LearnedElement
from modallab.core.rig import Rig
from modallab.gap.words.learned import learned_in_words


@pytest.mark.parametrize(
    ("element", "numbers", "words"),
    [
        ("point_law", {"k": 120.0, "c": 0.5}, "a spring of 120 N/m to ground and a damper of 0.5 N s/m to ground"),
        (
            "point_law",
            {"hung_m": 0.0252, "hung_hz": 11.4},
            "a mass of 25.2 g on a spring with a resonance of its own at 11.4 Hz",
        ),
        ("point_law", {"m": -0.004}, "a mass of -4 g"),
        ("beam_law", {"tension": -30.0}, "a push of 30 N along the beam's axis"),
        ("side_modes", {"twist_hz": 171.0, "kg": 3.0, "zeta": 0.005}, "modes of twisting, the lowest at 171 Hz"),
        (
            "side_modes",
            {"across_hz": 61.0, "kg": 2.0, "zeta": 0.004},
            "modes of bending across the drive, the lowest at 61 Hz",
        ),
        ("side_modes", {"alone_hz": 47.0, "kg": 4.0, "zeta": 0.01}, "one mode more at 47 Hz, largest at the tip"),
        ("row_filter", {"gain": 0.9, "delay": -0.0002}, "a factor of 0.9 and a delay of -0.2 ms"),
        ("row_curve", {"knee_v": 2.0, "power": 8.0}, "a saturation that levels off at 2 V, with a knee of power 8,"),
        ("row_curve", {"square": 0.02, "cubic": -0.1}, "a bent scale, u + 0.02 u^2 + -0.1 u^3 of u in V,"),
        ("row_hold", {"share": 0.05, "kept": 0.0}, "a loss of 5 % of the samples, with 0 in their place,"),
    ],
)
def test_each_number_is_said_in_its_unit(element: str, numbers: dict[str, float], words: str, rig: Rig) -> None:
    assert learned_in_words([LearnedElement(element=element, parameters=numbers)], rig) == words


def test_where_it_acts_follows(rig: Rig) -> None:
    spring = LearnedElement(element="point_law", parameters={"k": 120.0}, place={"x": 0.5, "x_m": 0.379})
    assert learned_in_words([spring], rig) == "a spring of 120 N/m to ground at 0.379 m"
    late = LearnedElement(element="row_filter", parameters={"delay": 0.001}, place={"channel": "all"})
    assert learned_in_words([late], rig) == "a delay of 1 ms on all accelerometers"
