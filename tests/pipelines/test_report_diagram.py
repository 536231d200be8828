"""The report shows how the modes of every kind of test were found."""

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.diagram import STABLE, StabilisationData
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import report_content
from modallab.reporting.report import render
from modallab.signals.signals import to_signals_of

FREQUENCIES = np.array([4.0, 5.0, 5.8, 6.1, 6.3, 6.6, 7.2, 8.5, 11.0, 15.0, 20.0, 30.0, 45.0, 52.0, 55.0, 57.0, 60.0])


@pytest.fixture(scope="module")
def hits() -> Campaign:
    rng = np.random.default_rng(4)
    blocks = bench.impact_blocks(bench.modes(rng), rng, points=(5,), hits=2)
    return Campaign(rig=bench.rig(5), blocks=tuple(blocks))


def diagram(campaign, options):
    result = identify_campaign(campaign, options)
    return report_content(campaign, result, "a test").outcomes[0], result.identified[0].model


@pytest.mark.thorough("identifies with every order, and draws")
def test_modes_of_hits_stand_as_columns_of_the_diagram_and_the_page_draws_it(hits):
    result = identify_campaign(hits, IdentificationOptions())
    content = report_content(hits, result, "a test")
    found = content.outcomes[0].diagram
    assert isinstance(found, StabilisationData)
    for hz in result.identified[0].model.frequency_hz:
        column = np.abs(found.frequency_hz / hz - 1) < 2e-3
        assert np.sum(found.standing[column] == STABLE) > 5
    page = render(content)
    assert "Stabilisation diagram" in page
    assert "CMIF" in page
    assert f"{result.identified[0].model.n_modes} modes stand in the model" in page


def test_peaks_of_given_frfs_are_drawn_beside_plscf(hits):
    frf = impact_frf(group_by_point(to_signals_of(hits.blocks, hits.rig)), hits.rig, (3.0, 200.0))
    outcome, model = diagram(
        Campaign(rig=hits.rig, blocks=(), frfs=(frf,)), IdentificationOptions(method="peak", band_hz=(3.0, 200.0))
    )
    assert model.method == "peak"
    assert isinstance(outcome.diagram, StabilisationData)


def test_a_stepped_sine_test_has_its_diagram():
    rng = np.random.default_rng(4)
    blocks = tuple(bench.sine_blocks(bench.modes(rng, 2), rng, FREQUENCIES))
    outcome, model = diagram(Campaign(rig=bench.rig(5), blocks=blocks), IdentificationOptions(method="peak"))
    assert isinstance(outcome.diagram, StabilisationData)
    assert outcome.diagram.line_hz.size == FREQUENCIES.size
    assert model.n_modes
