"""A small crack is nearly a small loss of stiffness: the lines about its overtones say what it is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.inference.select import Level
from modallab.gap.model.fit import Fit, Problem, evaluated
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import minimise
from modallab.gap.model.residual_shares import unexplained
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.choose import choose, effect_names
from modallab.gap.search.few_blocks import compared_sines
from modallab.gap.search.fitting import Bench, within_tolerances
from modallab.gap.search.overtone_lines import LINES, with_overtones
from modallab.gap.search.rough_fit import robust_fit
from modallab.gap.search.rough_starts import is_overtone, relative_residual
from modallab.twin.effects import model_of
from modallab.twin.effects.breathing_crack import WIDTH
from modallab_simulators.cantilever.cracked import HALF_WIDTH

LOSS = 0.2
OWN = 3
"""Numbers of a crack: how much, how far, where."""
CRACK = Effect(effect="breathing_crack", parameters={"EI_loss_open": LOSS}, place={"x": 0.31})


@pytest.fixture(scope="module")
def cracked(make: Callable[..., Campaign]) -> tuple[Bench, PreparedCampaign]:
    campaign = make(CRACK, tests=("sine",))
    prepared = prepare_campaign(replace(campaign, blocks=campaign.blocks[::4]))
    return problem_of_records(
        prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: True
    ), prepared


def fitted(on: Bench, loss: float, width: float = WIDTH) -> Fit:
    """The crack at its place, so large and so wide; no crack at 0."""
    problem = Problem(on.data, on.free)
    if not loss:
        return evaluated(problem, np.zeros(on.free.size))
    candidate = model_of("breathing_crack").candidates(on.data.rig)[0]
    own = [s.coordinate({"EI_loss_open": loss, "width": width, "x": 0.31}[s.name]) for s in candidate.slots]
    return evaluated(replace(problem, candidates=(candidate,)), np.concatenate([np.zeros(on.free.size), own]))


def test_the_law_makes_what_stands_about_the_overtones_and_a_linear_beam_nothing(
    cracked: tuple[Bench, PreparedCampaign],
) -> None:
    on, _ = cracked
    few = compared_sines(on.data, on.overtones, 6)
    assert few.sines is not None
    above, used = is_overtone(few), np.isfinite(few.sines.rows.sigma[:, ::LINES])
    assert np.any(above)
    left = {
        loss: relative_residual(replace(fitted(on, loss).problem, data=few), fitted(on, loss).u) for loss in (0.0, LOSS)
    }
    # The bench's crack weakens the beam beside it a little otherwise than the twin's.
    assert np.median(left[LOSS][:, above][used[:, above]]) < 0.35
    assert np.median(left[0.0][:, above][used[:, above]]) > 0.95
    # Half of the loss is worse: the overtones know the size.
    half = fitted(on, LOSS / 2)
    assert np.median(relative_residual(replace(half.problem, data=few), half.u)[:, above][used[:, above]]) > 0.5


@pytest.fixture(scope="module")
def law(cracked: tuple[Bench, PreparedCampaign]) -> Fit:
    """The crack of the right size on the beam that sines and overtones show."""
    on, _ = cracked
    fit = fitted(on, LOSS)
    sines = replace(fit.problem, data=with_overtones(on.data, on.overtones))
    return evaluated(fit.problem, np.concatenate([robust_fit(sines, fit.u, 2)[:-OWN], fit.u[-OWN:]]))


@pytest.mark.thorough("fits a law to a whole campaign")
def test_a_law_is_named_though_a_beam_within_its_tolerances_follows_the_sines_themselves(
    cracked: tuple[Bench, PreparedCampaign], law: Fit
) -> None:
    on, _ = cracked
    base = minimise(fitted(on, 0.0).problem, fitted(on, 0.0).u, 6, 1e-3)
    assert within_tolerances(base)
    assert unexplained(on.data, forward(twin_of(base, on.data), on.data)) < on.data.rig.tolerance.response
    said = choose(on, [Level(base, (law,))], on.data)
    assert said.explained
    assert effect_names(said.fit) == ("breathing_crack",)


def test_how_far_a_crack_weakens_the_beam_is_a_number_of_its_own(cracked: tuple[Bench, PreparedCampaign]) -> None:
    on, _ = cracked
    few = compared_sines(on.data, on.overtones, 6)
    assert few.sines is not None
    above, used = is_overtone(few), np.isfinite(few.sines.rows.sigma[:, ::LINES])
    left = {}
    for width in (HALF_WIDTH, 1.5 * HALF_WIDTH):
        fit = fitted(on, LOSS, width)
        left[width] = np.median(relative_residual(replace(fit.problem, data=few), fit.u)[:, above][used[:, above]])
    assert left[HALF_WIDTH] < 0.5 * left[1.5 * HALF_WIDTH]
    assert "width" in [s.name for s in fit.problem.candidates[0].slots]
