"""What is left of a bench without the element that is stepped in time, and that nothing is made up beside it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.beside_stepped import linear_beside_stepped, linear_fit, without_element
from modallab.gap.search.fitting import Bench
from modallab.twin.effects import model_of

DRAG = Effect(effect="air_drag", parameters={"c2_total": 20.0}, place={"x": "all"})
FRICTION = Effect(
    effect="clamp_friction",
    parameters={"k_slip": 2000.0, "k_stick": 9000.0, "moment_limit": 0.05, "sharpness": 1.5},
    place={"x": 0.0},
)


@pytest.fixture(scope="module")
def prepared(make: Callable[..., Campaign]) -> PreparedCampaign:
    return prepare_campaign(make(DRAG, tests=("sine",)))


def bench_with(prepared: PreparedCampaign, *allowed: str) -> Bench:
    return problem_of_records(
        prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda name: name in allowed
    )


def fit_of(bench: Bench, effect: Effect) -> Fit:
    """The twin with an effect as it is, on the beam as believed."""
    candidate = model_of(effect.effect).candidates(bench.data.rig)[0]
    own = [s.coordinate(effect.parameters[s.name]) for s in candidate.slots]
    u = np.concatenate([np.zeros(bench.free.size), own])
    problem = Problem(bench.data, bench.free, (candidate,))
    r = problem.residual(u)
    return Fit(problem, u, float(r @ r), r, np.eye(len(u)))


def made_by(data: Reduced, answers: list[np.ndarray]) -> Reduced:
    assert data.sines is not None
    return replace(data, sines=replace(data.sines, rows=replace(data.sines.rows, y=answers[-1])))


def test_records_without_what_the_element_adds_are_those_of_a_linear_beam(prepared: PreparedCampaign) -> None:
    bench = bench_with(prepared)
    twin = fit_of(bench, DRAG).problem.twin(fit_of(bench, DRAG).u)
    linear = forward(replace(twin, element=None), bench.data)[-1]
    left = without_element(made_by(bench.data, forward(twin, bench.data)), twin)
    assert left.sines is not None
    np.testing.assert_allclose(left.sines.rows.y, linear, rtol=1e-12)


def test_a_root_that_slips_stays_soft_without_its_friction(prepared: PreparedCampaign) -> None:
    bench = bench_with(prepared)
    fit = linear_fit(bench, fit_of(bench, FRICTION))
    (root,) = fit.effects
    assert root.effect == "clamp_rotation"
    assert root.parameters["k_rot"] == pytest.approx(FRICTION.parameters["k_slip"])


def test_where_nothing_linear_may_be_named_nothing_stands_beside(prepared: PreparedCampaign) -> None:
    bench = bench_with(prepared)
    assert linear_beside_stepped(bench, fit_of(bench, DRAG)) is None
