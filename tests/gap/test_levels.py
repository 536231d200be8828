"""Levels of the sines that disagree show what depends on the size of the motion, with or without overtones."""

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.model.fit import Problem, fit_at
from modallab.gap.model.nuisances import nuisances
from modallab.gap.report.harmonics import levels_differ
from modallab.gap.report.initial_gap import TOP_HZ, problem_of_records

CUBIC = Effect(effect="cubic_spring", parameters={"k3": 3e9}, place={"x": 0.6})
HEAVY = Effect(effect="added_mass", parameters={"mass": 0.2}, place={"x": 0.9})
MASS = Effect(effect="added_mass", parameters={"mass": 0.02}, place={"x": 0.7})


def as_the_rig_says(rig, make, *effects):
    prepared = prepare_campaign(make(*effects, tests=("sine",)))
    free = nuisances(rig, TOP_HZ)
    bench = problem_of_records(prepared, prepared.blocks, free, lambda _: True)
    return fit_at(Problem(bench.data, free, ()), np.zeros(free.size))


@pytest.mark.parametrize(("effects", "differ"), [((CUBIC,), True), ((MASS,), False), ((HEAVY,), False), ((), False)])
def test_levels_disagree_where_a_spring_hardens_and_not_where_a_mass_is_added(rig, make, effects, differ):
    base = as_the_rig_says(rig, make, *effects)
    assert levels_differ(base) is differ


def test_without_sines_no_level_can_disagree(rig, make):
    prepared = prepare_campaign(make(CUBIC, tests=("impact",)))
    free = nuisances(rig, TOP_HZ)
    bench = problem_of_records(prepared, prepared.blocks, free, lambda _: True)
    assert not levels_differ(fit_at(Problem(bench.data, free, ()), np.zeros(free.size)))
