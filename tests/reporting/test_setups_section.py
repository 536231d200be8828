"""The table that holds the set-ups of one test side by side."""

from dataclasses import replace

import numpy as np
import pytest
from page_reader import Page

from modallab.identification.setups.readings import SetUpReading
from modallab.reporting.content import ReportContent
from modallab.reporting.sections import setups


def reading(content: ReportContent, name: str, shift: float = 0.0, *, off: bool = False) -> SetUpReading:
    model = content.models[0]
    n = model.n_modes
    sigma = model.frequency_hz * 1e-5
    return SetUpReading(
        name,
        model.frequency_hz * (1 + shift),
        sigma,
        model.damping_ratio,
        np.full(n, np.nan),
        np.full(n, off),
        "left",
    )


@pytest.fixture
def page(content: ReportContent) -> Page:
    found = (reading(content, "left"), reading(content, "middle"), reading(content, "right", -0.0012, off=True))
    return Page(str(setups.setups_section(replace(content, setups=found)).render()))


def test_every_set_up_stands_below_the_joined_value_of_each_mode(page: Page, content: ReportContent) -> None:
    (table,) = page.tables
    n = content.models[0].n_modes
    assert len(table.rows) == 1 + 4 * n
    assert [row[1] for row in table.rows[1:5]] == ["joined", "left", "middle", "right off"]
    assert table.rows[4][3] == "−0.12 % (−120 σ)"


def test_the_set_up_that_is_off_is_named_with_its_modes(page: Page) -> None:
    assert "Off: set-up right (modes 1, 2" in page.sections["set-ups"]
    assert "compared with left" in page.sections["set-ups"]


def test_of_two_none_is_blamed(content: ReportContent) -> None:
    two = (reading(content, "left"), reading(content, "right", 0.001, off=True))
    assert "do not show which one is off" in setups.setups_section(replace(content, setups=two)).render()


def test_one_set_up_needs_no_table(content: ReportContent) -> None:
    assert setups.setups_section(content).body is None
