"""What each free number does to the data, to first order, is what it does by a small step."""

import numpy as np
import pytest
from twin_campaign import built, link

from modallab.core.rig import Tolerance
from modallab.gap.conditioning.reduce import reduce_blocks, select_lines
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.model.fit import Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.nuisances import Nuisances, nuisances
from modallab.gap.report.fitted_numbers import fitted_numbers

RIG = link().model_copy(update={"tolerance": Tolerance.usual()})
FREE: Nuisances = nuisances(RIG, 260.0, [(0.6, 2), (1.0, 2), (0.3, 2)])
STEP = 2e-3


@pytest.fixture(scope="module")
def data() -> Reduced:
    campaign = built(RIG)
    whole = reduce_blocks(campaign, campaign.blocks, Weights(np.full(len(RIG.channels), 3e-4)))
    return select_lines(whole, np.array([2j * np.pi * f for f in (4.9, 30.8, 86.0)]))


@pytest.fixture(scope="module")
def slopes(data: Reduced) -> tuple[Problem, np.ndarray, np.ndarray]:
    problem = Problem(data, FREE)
    u = np.random.default_rng(5).normal(0, 0.5, FREE.size)
    return problem, u, jacobian(problem, u, problem.residual(u))


NAMES = [
    f"{m.name} {m.place}".strip()
    for m in fitted_numbers(Problem(Reduced(RIG, (), None, (), np.zeros(0), 1.0), FREE), np.zeros(FREE.size))
]


@pytest.mark.parametrize("k", range(FREE.size), ids=NAMES)
def test_a_slope_is_a_small_steps(slopes: tuple[Problem, np.ndarray, np.ndarray], k: int) -> None:
    problem, u, J = slopes
    step = STEP * np.eye(len(u))[k]
    plain = (problem.residual(u + step) - problem.residual(u - step)) / (2 * STEP)
    assert np.linalg.norm(J[:, k] - plain) < 0.02 * np.linalg.norm(plain) + 1e-6
