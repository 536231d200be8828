"""Table 1 of the paper is explained by what its block can resolve."""

import pytest

from modallab.cli import main
from modallab.pipelines.paper import LINE_HZ, PaperExplained, explain_paper


@pytest.fixture(scope="module")
def found() -> PaperExplained:
    return explain_paper()


@pytest.mark.thorough("records and identifies the bench of a paper")
def test_the_first_damping_is_that_of_the_block_whatever_the_beam(found: PaperExplained) -> None:
    first = found.modes[0]
    assert 0.06 < first.plain[0] < first.plain[1] < 0.075
    assert 0.12 <= first.hann[0] < first.hann[1] < 0.125
    assert first.as_width == pytest.approx(0.0625)


def test_the_first_and_the_third_frequency_are_lines_and_the_second_is_none(found: PaperExplained) -> None:
    assert [(mode.line, mode.on_line) for mode in found.modes] == [(5, True), (32, False), (90, True)]


def test_a_root_spring_and_a_tip_mass_fit_equally(found: PaperExplained) -> None:
    _, spring, mass = found.explanations
    assert spring.best == pytest.approx(13.5, abs=1.5)
    assert 1 / (mass.best or 1) == pytest.approx(13.5, abs=1.5)
    assert found.apart_hz < 1e-3 * LINE_HZ


def test_lines_so_far_apart_exclude_not_even_an_ideal_clamp(found: PaperExplained) -> None:
    rigid, spring, mass = found.explanations
    assert rigid.worst_lines < 0.5
    assert spring.allowed is not None
    assert mass.allowed is not None
    assert any("Such lines cannot exclude the ideal clamp either" in line for line in found.said)


@pytest.mark.thorough("records and identifies the bench of a paper")
def test_at_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["gap", "paper"]) == 0
    assert "both are the block, not the beam" in " ".join(capsys.readouterr().out.split())
