"""A small crack is nearly a small loss of stiffness: the lines about its overtones say what it is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import PreparedCampaign, prepare_campaign
from modallab.gap.inference.select import SearchRound
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.inference.view import RowModel
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import minimise
from modallab.gap.model.residual_shares import unexplained
from modallab.gap.model.twin_of_fit import twin_of
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.choose import effect_names, select_explanation
from modallab.gap.search.few_blocks import compared_sines
from modallab.gap.search.fitting import Bench, within_tolerances
from modallab.gap.search.laws import fit_on_all_records
from modallab.twin.effects import model_of
from modallab.twin.effects.breathing_crack import WIDTH
from modallab_simulators.cantilever.cracked import HALF_WIDTH

LOSS = 0.2
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
        return fit_at(problem, np.zeros(on.free.size))
    candidate = model_of("breathing_crack").candidates(on.data.rig)[0]
    own = [s.coordinate({"EI_loss_open": loss, "width": width, "x": 0.31}[s.name]) for s in candidate.slots]
    return fit_at(replace(problem, candidates=(candidate,)), np.concatenate([np.zeros(on.free.size), own]))


def overtone_scale(on: Bench, fit: Fit) -> float:
    """How far a model is off the overtones of a few sines, as a share of their size; median."""
    view = RowModel.of((), compared_sines(on.data, on.overtones, 6), DEFAULT, "record")
    levels = view.objective.levels(view.residual(fit.problem.twin(fit.u)))
    rows = view.objective.rows
    shown = {rows.names[k] for k in rows.group[np.isfinite(rows.sigma)]}
    scales = dict(zip(rows.names, view.objective.values(levels), strict=True))
    return float(np.median([scales[n] for n in shown if "group" in n and not n.endswith("group 1")]))


def test_the_law_makes_what_stands_about_the_overtones_and_a_linear_beam_nothing(
    cracked: tuple[Bench, PreparedCampaign],
) -> None:
    on, _ = cracked
    none, half, whole = (overtone_scale(on, fitted(on, loss)) for loss in (0.0, LOSS / 2, LOSS))
    # The overtones know the size; the bench's crack weakens the beam beside it a little otherwise than the twin's.
    assert whole < 0.5 * half < none


@pytest.fixture(scope="module")
def law(cracked: tuple[Bench, PreparedCampaign]) -> Fit:
    """The crack of the right size on the beam that the sines show."""
    on, _ = cracked
    fit = fitted(on, LOSS)
    return fit_on_all_records(on, fit.problem.candidates, fit.u)


@pytest.mark.thorough("fits a law to a whole campaign")
def test_a_law_is_named_though_a_beam_within_its_tolerances_follows_the_sines_themselves(
    cracked: tuple[Bench, PreparedCampaign], law: Fit
) -> None:
    on, _ = cracked
    base = minimise(fitted(on, 0.0).problem, fitted(on, 0.0).u, 6, 1e-3)
    assert within_tolerances(base)
    assert unexplained(on.data, forward(twin_of(base, on.data), on.data)) < on.data.rig.tolerance.response
    said = select_explanation(on, [SearchRound(base, (law,))], on.data)
    assert said.explained
    assert effect_names(said.fit) == ("breathing_crack",)


def test_how_far_a_crack_weakens_the_beam_is_a_number_of_its_own(cracked: tuple[Bench, PreparedCampaign]) -> None:
    on, _ = cracked
    right, wide = (overtone_scale(on, fitted(on, LOSS, width)) for width in (HALF_WIDTH, 1.5 * HALF_WIDTH))
    assert right < 0.6 * wide
    assert "width" in [s.name for s in fitted(on, LOSS).problem.candidates[0].slots]
