"""A spring's place is read off all records, along the valley where the slowest mode stiffens alike."""

from dataclasses import replace

import numpy as np
import pytest
from twin_campaign import built, link

from modallab.core.rig import Tolerance
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.rows import ImpactData, Reduced
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import jacobian
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.along_beam import best_along_beam
from modallab.twin.bench import Twin
from modallab.twin.effects import model_of
from modallab.twin.modes import solve_modes

PLACE, ELSEWHERE, K3 = 0.82, 0.65, 2e6


@pytest.fixture(scope="module")
def elsewhere() -> Fit:
    """The twin with a cubic spring at another place, as strong on the slowest mode, on hits of one where it is."""
    rig = link().model_copy(update={"tolerance": Tolerance.usual()})
    prepared = prepare_campaign(built(rig, tests=("impact",)))
    bench = problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: True)
    (candidate,) = model_of("cubic_spring").candidates(rig)
    problem = Problem(bench.data, bench.free, (candidate,))
    k3, x = candidate.slots
    u = np.concatenate([np.zeros(bench.free.size), [k3.coordinate(K3), x.coordinate(PLACE)]])
    twin = problem.twin(u)
    shape = abs(solve_modes(twin.structure).shapes_at(np.array([PLACE, ELSEWHERE]) * twin.structure.length_m)[:, 0])
    u[-2:] = k3.coordinate(K3 * (shape[0] / shape[1]) ** 4), x.coordinate(ELSEWHERE)
    return fit_at(replace(problem, data=struck(bench.data, twin)), u)


def struck(data: Reduced, twin: Twin) -> Reduced:
    """The hits as a twin answers them, with their noise."""
    rng = np.random.default_rng(3)
    hits: list[ImpactData] = []
    for d, y in zip(data.impacts, forward(twin, data), strict=True):
        noise = np.where(np.isfinite(d.rows.sigma), d.rows.sigma, 0.0)
        drawn = noise * (rng.standard_normal(y.shape) + 1j * rng.standard_normal(y.shape))
        hits.append(replace(d, rows=replace(d.rows, y=y + drawn)))
    return replace(data, impacts=tuple(hits))


@pytest.mark.thorough("fits along the beam")
def test_the_place_that_fits_all_records_is_the_springs(elsewhere: Fit) -> None:
    (found,) = best_along_beam(elsewhere).effects
    assert found.place.x == pytest.approx(PLACE, abs=0.015)
    assert found.parameters["k3"] == pytest.approx(K3, rel=0.1)


@pytest.mark.thorough("fits along the beam")
def test_a_law_that_does_nothing_has_no_better_place(elsewhere: Fit) -> None:
    u = elsewhere.u.copy()
    u[-2] = elsewhere.problem.candidates[0].slots[0].coordinate(1e-12)
    nothing = fit_at(elsewhere.problem, u)
    assert best_along_beam(nothing).cost <= nothing.cost


def test_a_law_that_is_tied_to_no_mode_stays_where_it_is(elsewhere: Fit) -> None:
    (root,) = model_of("clamp_friction").candidates(elsewhere.problem.data.rig)
    own = [s.coordinate(s.starts[0]) for s in root.slots]
    problem = Problem(elsewhere.problem.data, elsewhere.problem.free, (root,))
    fit = fit_at(problem, np.concatenate([np.zeros(problem.free.size), own]))
    assert best_along_beam(fit) is fit


def test_whole_slopes_are_small_steps_where_an_element_is_stepped(elsewhere: Fit) -> None:
    problem, u = elsewhere.problem, elsewhere.u
    J = jacobian(problem, u, elsewhere.residual, whole=True)
    for k in (problem.free.first_deviation, problem.free.size - 1):
        step = 2e-3 * np.eye(len(u))[k]
        plain = (problem.residual(u + step) - problem.residual(u - step)) / 4e-3
        assert np.linalg.norm(J[:, k] - plain) < 0.02 * np.linalg.norm(plain) + 1e-6
