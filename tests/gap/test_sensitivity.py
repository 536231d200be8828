"""Slopes through poles and residues against differences of the whole prediction."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.model.candidates import beam_candidates, channel_candidates
from modallab.gap.model.fit import Problem
from modallab.gap.model.minimise import jacobian
from modallab.gap.model.nuisances import nuisances
from modallab.gap.model.sensitivity import differ_smoothly
from modallab.twin.candidate import CandidateEffect
from modallab.twin.modes import solve_modes

STEP = 1e-3


@pytest.fixture(scope="module")
def data(make: Callable[..., Campaign]) -> Reduced:
    campaign = make()
    prepared = prepare_campaign(campaign)
    return reduce_blocks(campaign, prepared.blocks, Weights(prepared.noise_v))


def every(rig: Rig) -> dict[str, CandidateEffect]:
    return {c.effect: c for c in (*beam_candidates(rig), *channel_candidates(rig, 4)) if c.slots}


MOVED = (
    "added_mass",
    "stiffness_loss",
    "local_damper",
    "thermal_drift",
    "shaker_mass",
    "hit_position",
    "position_error",
    "gain_error",
    "force_gain",
    "clock_error",
    "channel_skew",
    "loose_mount",
    "ac_coupling",
)


@pytest.mark.parametrize("effect", MOVED)
def test_slopes_are_those_of_the_whole_prediction(rig: Rig, data: Reduced, effect: str) -> None:
    candidate = every(rig)[effect]
    problem = Problem(data, nuisances(rig, 450.0), (candidate,), 0.01)
    start = [s.coordinate(s.starts[len(s.starts) // 2]) for s in candidate.slots]
    u = np.concatenate([np.full(problem.free.size, 0.1), start])
    J = jacobian(problem, u, problem.residual(u))
    for k in range(len(u)):
        step = STEP * np.eye(len(u))[k]
        slope = (problem.residual(u + step) - problem.residual(u - step)) / (2 * STEP)
        assert np.linalg.norm(J[:, k] - slope) < 5e-3 * np.linalg.norm(slope) + 1e-6


@pytest.mark.parametrize("effect", MOVED)
def test_beside_every_effect_the_beam_goes_through_poles_and_residues(rig: Rig, data: Reduced, effect: str) -> None:
    """A prediction of all records for each free number would take several times as long."""
    candidate = every(rig)[effect]
    problem = Problem(data, nuisances(rig, 450.0), (candidate,))
    u = np.concatenate([np.zeros(problem.free.size), [s.coordinate(s.starts[0]) for s in candidate.slots]])
    softer = u.copy()
    softer[0] -= STEP
    assert differ_smoothly(problem.twin(u), problem.twin(softer))


def test_a_drift_beside_leaves_the_slopes_right(rig: Rig, data: Reduced) -> None:
    both = (every(rig)["thermal_drift"], every(rig)["added_mass"])
    problem = replace(Problem(data, nuisances(rig, 450.0), both), floor=0.01)
    u = np.concatenate([np.zeros(problem.free.size), [2.0], [np.log(0.03), 0.6]])
    J = jacobian(problem, u, problem.residual(u))
    step = STEP * np.eye(len(u))[-1]
    slope = (problem.residual(u + step) - problem.residual(u - step)) / (2 * STEP)
    assert np.linalg.norm(J[:, -1] - slope) < 5e-3 * np.linalg.norm(slope)


def test_slopes_lead_past_a_damper_that_stops_a_mode_from_swinging(rig: Rig, data: Reduced) -> None:
    damper = every(rig)["local_damper"]
    problem = Problem(data, nuisances(rig, 450.0), (damper,), 0.01)
    free = np.zeros(problem.free.size)

    def numbers(c: float) -> np.ndarray:
        slots = {s.name: s.coordinate(v) for s, v in zip(damper.slots, (c, 0.95), strict=True)}
        return np.concatenate([free, [slots[s.name] for s in damper.slots]])

    def poles(c: float) -> int:
        return len(solve_modes(problem.twin(numbers(c)).structure).poles)

    # A little below where the number of poles changes: a step of the slopes passes it.
    low, high = 1.0, next(c for c in np.geomspace(2.0, 1e4, 60) if poles(c) != poles(1.0))
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if poles(middle) == poles(1.0) else (low, middle)
    u = numbers(low * (1 - 0.3e-4))
    J = jacobian(problem, u, problem.residual(u))
    step = STEP * np.eye(len(u))[-2]
    slope = (problem.residual(u + step) - problem.residual(u - step)) / (2 * STEP)
    assert np.linalg.norm(J[:, -2] - slope) < 5e-3 * np.linalg.norm(slope)
