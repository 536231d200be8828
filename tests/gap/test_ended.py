"""A fit whose beam has strayed far outside its tolerances finds its way back."""

import numpy as np

from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import prepare
from modallab.gap.model.candidates import of_bench
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.nuisances import nuisances
from modallab.gap.report.initial_gap import TOP_HZ, bench_of
from modallab.gap.search.fitting import COARSE, annealed, completed
from modallab.gap.search.round import ended


def strayed(rig, make, beam):
    prepared = prepare(make(Effect(effect="sensor_mass", parameters={"mass_each": 0.02}, place={"x": "all"})))
    free = nuisances(rig, TOP_HZ)
    bench = bench_of(prepared, prepared.blocks, free, lambda _: True)
    (candidate,) = (c for c in of_bench(rig) if c.effect == "sensor_mass")
    u = np.concatenate([np.zeros(free.size), [candidate.slots[0].coordinate(0.013)]])
    u[:3] = beam
    problem = Problem(bench.thin, free, (candidate,))
    r = problem.residual(u)
    return bench, Fit(problem, u, float(r @ r), r, np.eye(len(u)))


def test_a_beam_far_outside_its_tolerances_is_begun_again_from_the_poles(rig, make):
    bench, fit = strayed(rig, make, (60.0, -40.0, -5.0))
    assert completed(bench, annealed(bench, fit, COARSE / 12)).gap > 1.5
    found = ended(bench, fit, COARSE / 12)
    assert found.gap < 1.1
    np.testing.assert_allclose(found.effects[0].parameters["mass_each"], 0.02, rtol=0.01)
