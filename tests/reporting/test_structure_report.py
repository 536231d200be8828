"""The page of a structure held against its modal model: what was found stands in it, and what was not looked at."""

import re
from dataclasses import replace

import numpy as np
import pytest
from closed_form_plate import OMEGA, REFERENCE, X, Y, model, rig, shapes, with_mass

from modallab.core.modal_diagnosis import FoundChange
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.gap.modal.diagnosis import ComparisonOutcome, explained_by_model
from modallab.gap.words.effects import numbers_of
from modallab.reporting.figures.structure_curves import worst_outputs
from modallab.reporting.figures.structure_picture import MarkedPlaces, structure_picture
from modallab.reporting.figures.wireframe import drawing_projection
from modallab.reporting.structure_report import StructureGap, render
from modallab.verification.verify import synthesised_frf

AT = (0.31, 0.17, 0.0)


def netted() -> Rig:
    """The plate's rig with a line along each row of points, and one face."""
    lines = tuple((n, n + 1) for n in range(1, 20) if n % 4)
    return rig().model_copy(update={"lines": lines, "surfaces": ((1, 2, 6, 5),)})


def gap(bench: ModalModel) -> StructureGap:
    return StructureGap(netted(), explained_by_model(REFERENCE, bench, netted()), "a modal model")


@pytest.fixture(scope="module")
def heavy() -> StructureGap:
    bench = with_mass(0.06, AT[0], AT[1])
    hz = np.linspace(6.0, 80.0, 200)
    return replace(gap(bench), records=synthesised_frf(bench, hz, "mobility"), beside=("Other tests: sine.",))


def read(page: str) -> str:
    return re.sub(r"<[^>]*>", " ", page).replace("\u00a0", " ")


def test_place_number_and_alternatives_stand_on_the_page(heavy: StructureGap) -> None:
    page = render(heavy)
    said = read(page)
    (effect,) = heavy.diagnosis.effects
    (_, value, between) = numbers_of(effect)[0]
    assert effect.parameters["mass"] == pytest.approx(0.06, rel=0.1)
    assert value in said
    assert between in said
    for candidate in heavy.diagnosis.candidates:
        # One between two points has no part in the ground.
        assert candidate.effects[0].replace("_", " ").removeprefix("ground ") in said
    assert "Other tests: sine." in said
    assert "records" in said


def test_nothing_on_the_page_comes_from_elsewhere(heavy: StructureGap) -> None:
    assert not re.search(r'(src|href)="(?!#)', render(heavy))


def test_the_gap_shrinks_at_every_channel_and_mode_that_the_mass_moves(heavy: StructureGap) -> None:
    found = heavy.diagnosis
    assert [p.name for p in found.by_channel] == ["a1", "a2", "a3"]
    hz = [p.frequency_hz for p in found.by_mode]
    np.testing.assert_allclose(hz, heavy.explained.free.of.bench.frequency_hz)
    for part in (*found.by_channel, *found.by_mode):
        assert part.after < 0.5 * part.nominal
    assert np.sqrt(np.mean([p.nominal**2 for p in found.by_channel])) == pytest.approx(found.nominal)


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_a_gap_that_is_none_marks_no_place() -> None:
    page = render(gap(model(1.005 * OMEGA, shapes(X, Y), (1.01, 0.99, 1.0))))
    assert "No effect stands out" in page
    assert "What causes it" not in page
    assert "var(--warning)" not in page.split("Where it lies")[1].split("</svg>")[0]


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_a_wrong_gain_is_marked_where_its_sensor_stands() -> None:
    found = gap(model(OMEGA, shapes(X, Y), (1.0, 0.8, 1.0)))
    assert "a2: gain error" in render(found)
    output, _ = worst_outputs(found.explained)[0]
    assert found.explained.free.of.model.outputs[output] == "a2"


def test_the_mark_stands_where_the_projection_puts_the_place() -> None:
    """Half way between two points in space it is half way between them on the drawing."""
    drawn = str(structure_picture(netted(), MarkedPlaces(np.array([[(X[0] + X[4]) / 2, Y[0], 0.0]]), label="here")))
    found = re.findall(r'cx="([^"]*)" cy="([^"]*)" r="([^"]*)"', drawn)
    circles = [(float(x), float(y), float(r)) for x, y, r in found]
    points = [c for c in circles if c[2] == 3.5]
    (mark,) = [c for c in circles if c[2] == 11.0]
    np.testing.assert_allclose(mark[:2], (np.array(points[0][:2]) + points[4][:2]) / 2, atol=0.1)
    across = np.array([X[4] - X[0], 0.0, 0.0]) @ drawing_projection()
    step = np.array(points[4][:2]) - points[0][:2]
    np.testing.assert_allclose(step / np.linalg.norm(step), across / np.linalg.norm(across), atol=0.02)


def test_a_number_that_the_records_leave_open_is_not_given_an_interval() -> None:
    change = FoundChange(
        effect="ground_spring", stage="structure", probability=0.1, parameters={"k": 196.0},
        interval={"k": (0.1, 4e5)}, place={"point": 3, "at_m": [0.0, 0.0, 0.0], "axis": "z"},
    )  # fmt: skip
    assert numbers_of(change) == [("stiffness", "about 200 N/m", "not known from the records")]


def test_every_explanation_that_was_fitted_is_listed_with_its_probability(heavy: StructureGap) -> None:
    explained: ComparisonOutcome = heavy.explained
    assert [c.effect for c in explained.ranked] == [c.effects[0] for c in explained.diagnosis.candidates]
    assert sum(c.probability for c in explained.ranked) <= 1.0
