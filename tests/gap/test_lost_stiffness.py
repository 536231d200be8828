"""Columns of a frame that lost stiffness or were braced, on clamps and on rollers, with a mode below the band."""

import pytest
from shear_frame import CLAMPS, ROLLERS, frf, model, rig

from modallab.core.effect import BetweenPoints, NearPoint
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.gap.words.effects import effect_with_numbers


def diagnosed(beneath: float, lost: tuple[int, float], frfs: bool = True) -> ModalDiagnosis:
    before, after = frf(1, beneath), frf(2, beneath, lost)
    return diagnose_by_model(model(before), model(after), rig(), frfs=(before, after) if frfs else (None, None))


@pytest.mark.thorough("identifies and compares a frame twice")
@pytest.mark.parametrize(("column", "k"), [(1, 45e3), (3, 315e3)])
@pytest.mark.parametrize("frfs", [True, False])
def test_a_column_that_lost_stiffness_is_found_between_its_floors(column: int, k: float, frfs: bool) -> None:
    (found,) = diagnosed(ROLLERS, (column, k), frfs).effects
    assert found.effect == "stiffness_loss"
    assert found.parameters["k"] == pytest.approx(k, rel=0.03)
    assert isinstance(found.place, BetweenPoints)
    assert found.place.points == (column, column + 1)
    assert f"stiffness loss between points {column} and {column + 1}, along x: stiffness " in effect_with_numbers(found)


@pytest.mark.thorough("identifies and compares a frame")
@pytest.mark.parametrize(("column", "k"), [(1, 45e3), (3, 9e3)])
def test_a_brace_is_a_spring_between_its_floors(column: int, k: float) -> None:
    (found,) = diagnosed(ROLLERS, (column, -k)).effects
    assert (found.effect, found.parameters["k"]) == ("ground_spring", pytest.approx(k, rel=0.03))
    assert effect_with_numbers(found).startswith(
        f"spring between points {column} and {column + 1}, along x: stiffness "
    )


@pytest.mark.thorough("identifies and compares a frame")
def test_a_support_that_gives_is_found_at_its_point() -> None:
    (found,) = diagnosed(CLAMPS, (0, 0.3 * CLAMPS)).effects
    assert (found.effect, found.parameters["k"]) == ("stiffness_loss", pytest.approx(0.3 * CLAMPS, rel=0.03))
    assert isinstance(found.place, NearPoint)
    assert found.place.point == 1


@pytest.mark.thorough("identifies and compares a frame twice")
@pytest.mark.parametrize("beneath", [ROLLERS, CLAMPS])
def test_a_frame_measured_twice_has_no_gap(beneath: float) -> None:
    assert diagnosed(beneath, (0, 0.0)).verdict == "no_gap"
