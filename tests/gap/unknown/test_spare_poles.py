"""A pole more than a beam has, and a force along its axis, are described; effects that come near are not named."""

from collections.abc import Callable

import pytest
from twin_campaign import bench

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import Effect
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.diagnosis import diagnose
from modallab.gap.export.mjcf import mjcf_text

Make = Callable[..., Campaign]


def made(name: str, **numbers: float) -> Effect:
    return Effect(effect=name, parameters=numbers, place={"x": "all"})


def near(name: str) -> bool:
    """Effects that come near, and no others: the search for them takes most of the time."""
    return name in {"stiffness_loss", "added_mass", "force_gain"}


@pytest.mark.thorough("diagnoses a whole campaign")
def test_modes_of_twisting_are_described(make: Make) -> None:
    numbers = {"twist_hz": 141.0, "kg": 4.0, "zeta": 0.004}
    diagnosis = diagnose(make(made("side_modes", **numbers), tests=("impact",)), allowed=near)
    _unknown_and_closed(diagnosis)
    assert diagnosis.described is not None
    (element,) = diagnosis.described.elements
    assert element.element == "side_modes"
    assert element.parameters["twist_hz"] == pytest.approx(141.0, rel=1e-3)
    assert element.parameters["kg"] == pytest.approx(4.0, rel=0.03)


@pytest.mark.thorough("diagnoses a whole campaign")
def test_a_push_along_the_axis_is_called_by_no_effect_that_comes_near(make: Make) -> None:
    diagnosis = diagnose(make(made("beam_law", tension=-9.0), tests=("impact",)), allowed=near)
    _unknown_and_closed(diagnosis)
    assert diagnosis.described is not None
    assert diagnosis.described.elements[0].parameters["tension"] == pytest.approx(-9.0, rel=0.02)


def test_a_chain_of_hinges_does_not_claim_to_twist(rig: Rig) -> None:
    twisting = bench(rig, (made("side_modes", twist_hz=141.0, kg=4.0, zeta=0.004),))
    with pytest.raises(DataError, match="twist"):
        mjcf_text(twisting, rig, "impact")


def _unknown_and_closed(diagnosis: Diagnosis) -> None:
    assert diagnosis.verdict == "unknown"
    assert diagnosis.effects == []
    assert diagnosis.described is not None
    closed = diagnosis.described.shrink.closed
    assert closed is not None
    assert closed > 0.99
