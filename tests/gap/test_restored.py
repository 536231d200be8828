"""What a diagnosis says of an explanation is enough to go on from it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from unsure import of_sensors, remaining_explanations

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.errors import DataError
from modallab.core.hold_out import MIXED, SPREAD
from modallab.core.rig import Rig, Tolerance
from modallab.gap.conditioning.records import split_held_out
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.design.planned import weights_by_converter_noise
from modallab.gap.model.candidates import beam_candidates
from modallab.gap.model.fit import Problem, fit_at
from modallab.gap.model.nuisances import nuisances
from modallab.gap.model.restored import coordinates_of_twin, start_from_diagnosis
from modallab.gap.report.calibrated import calibrated_twin
from modallab.gap.search.best_place import at_best_place

MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})


@pytest.fixture(scope="module")
def few(make: Callable[..., Campaign]) -> Campaign:
    return of_sensors(make(MASS, tests=("impact",)), (6, 10))


def as_built(campaign: Campaign) -> Rig:
    return campaign.rig.model_copy(update={"tolerance": Tolerance.usual()})


def test_the_numbers_of_a_fit_come_back_from_its_document(few: Campaign) -> None:
    rig = as_built(few)
    data = reduce_blocks(few, few.blocks, weights_by_converter_noise(rig))
    free = nuisances(rig, 450.0, [(0.6, 2), (1.0, 2), (0.3, 2)])
    u = np.random.default_rng(1).uniform(-3.4, 3.4, free.size)
    u[-1] = 0.7
    said = calibrated_twin(fit_at(Problem(data, free), u), data)
    assert coordinates_of_twin(said, free) == pytest.approx(u, abs=1e-6)


def test_what_the_document_does_not_mention_is_as_the_rig_file_has_it(few: Campaign) -> None:
    rig = as_built(few)
    data = reduce_blocks(few, few.blocks, weights_by_converter_noise(rig))
    before, after = (nuisances(rig, 450.0, hits) for hits in ([(0.6, 2)], [(0.6, 2), (0.9, 5)]))
    said = calibrated_twin(fit_at(Problem(data, before), np.full(before.size, 0.5)), data)
    found = coordinates_of_twin(said, after)
    new = [k for k, d in enumerate(after.deviations) if d.at == 0.9 and d.tolerance.startswith("hit")]
    assert new
    assert np.all(found[[after.first_deviation + k for k in new]] == 0)
    assert np.count_nonzero(found == 0) == len(new)


def test_an_explanation_begins_with_its_own_effect(few: Campaign) -> None:
    data = reduce_blocks(few, few.blocks, weights_by_converter_noise(few.rig))
    (said, *_) = remaining_explanations(few.rig, MASS).candidates
    problem, u = start_from_diagnosis(said, data, nuisances(few.rig, 450.0))
    (effect,) = problem.effects(u)
    assert effect.parameters["mass"] == pytest.approx(0.05)
    assert effect.place.x == pytest.approx(0.8)
    held, v = start_from_diagnosis(said, data, nuisances(few.rig, 450.0), in_place=True)
    assert len(v) == len(u) - 1
    assert held.effects(v)[0].place.x == pytest.approx(0.8)


def test_an_effect_that_the_rig_cannot_have_is_said_so(few: Campaign) -> None:
    hung = Effect(effect="shaker_mass", parameters={"mass": 0.1}, place={"x": 0.4})
    (said, *_) = remaining_explanations(few.rig, hung).candidates
    bare = few.rig.model_copy(update={"shaker_point": None})
    data = reduce_blocks(few, few.blocks, weights_by_converter_noise(bare))
    with pytest.raises(DataError, match="no fit looks for shaker_mass"):
        start_from_diagnosis(said, replace(data, rig=bare), nuisances(bare, 450.0))


def test_a_mass_is_found_where_it_is_from_where_it_is_not(few: Campaign) -> None:
    fitted, _ = split_held_out(few.blocks, SPREAD)
    data = reduce_blocks(few, fitted, weights_by_converter_noise(few.rig))
    free = nuisances(few.rig, 450.0)
    mass = next(c for c in beam_candidates(few.rig) if c.effect == "added_mass")
    own = [s.coordinate({"mass": 0.02, "x": 0.35}[s.name]) for s in mass.slots]
    stuck = fit_at(Problem(data, free, (mass,)), np.concatenate([np.zeros(free.size), own]))
    found = at_best_place(stuck)
    assert found.effects[0].place.x == pytest.approx(0.8, abs=0.01)
    assert found.gap < 2.0


def test_spread_keeps_hits_of_every_point_to_fit(few: Campaign) -> None:
    fitted, held = split_held_out(few.blocks, SPREAD)
    assert {b.drive_point for b in fitted} == {3, 6, 10}
    assert not held
    _, last = split_held_out(few.blocks, MIXED)
    assert {b.drive_point for b in last} == {3}
