"""What else is wrong with a bench of which the rig file knows an effect that is stepped in time."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
from made_diagnosis import made_diagnosis

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.inference.baseline import baseline
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.revisions import with_diagnosis
from modallab.gap.search.beside_known import knows_element, linear_beside_known
from modallab.gap.search.beside_stepped import linear_part
from modallab.gap.search.fitting import Bench

pytestmark = pytest.mark.thorough("fits with an element that is stepped in time")

DRAG = Effect(effect="air_drag", parameters={"c2_total": 20.0}, place={"x": "all"})
GAIN = Effect(effect="gain_error", parameters={"gain": 1.3}, place={"channel": 4})


@pytest.fixture(scope="module")
def bench(make: Callable[..., Campaign], rig: Rig) -> Bench:
    revised = with_diagnosis(rig, made_diagnosis(rig, DRAG), date(2026, 5, 4))
    prepared = prepare_campaign(replace(make(DRAG, GAIN, tests=("sine",)), rig=revised))
    return problem_of_records(
        prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda name: name == "gain_error"
    )


@pytest.fixture(scope="module")
def base(bench: Bench) -> Fit:
    """The element on the beam that fits without it: near enough."""
    beam = baseline(replace(bench, free=replace(bench.free, stepped=False)))
    return fit_at(Problem(bench.data, bench.free, ()), beam.u)


def test_a_beam_without_what_the_known_element_adds_leaves_the_same(bench: Bench, base: Fit) -> None:
    linear, free = linear_part(bench, base), replace(bench.free, stepped=False)
    assert knows_element(base)
    begin = fit_at(Problem(linear.data, free, ()), base.u)
    assert not knows_element(begin)
    np.testing.assert_allclose(begin.residual, base.residual, atol=1e-6 * np.abs(base.residual).max())


def test_where_nothing_may_be_named_the_bench_stays_as_it_is(bench: Bench, base: Fit) -> None:
    choice = linear_beside_known(replace(bench, allowed=lambda _: False), base, None)
    assert (choice.base, choice.fit, choice.explained) == (base, base, False)
