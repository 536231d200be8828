"""A fit whose beam has strayed far outside its tolerances finds its way back."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.core.rig import Tolerance
from modallab.gap.conditioning.prepare import prepare
from modallab.gap.model.candidates import of_bench
from modallab.gap.model.fit import Fit, Problem, seen
from modallab.gap.model.nuisances import nuisances
from modallab.gap.report.initial_gap import TOP_HZ, bench_of, free_of
from modallab.gap.search import ending
from modallab.gap.search.ending import ended
from modallab.gap.search.fitting import COARSE, annealed, baseline, completed, excess, on_all, ordinary, short
from modallab.gap.search.pool import pool
from modallab.gap.search.round import taking_half


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
    found = ended(bench, fit, COARSE / 12, 10.0)
    assert found.gap < 1.1
    np.testing.assert_allclose(found.effects[0].parameters["mass_each"], 0.02, rtol=0.01)


@pytest.mark.thorough("fits a whole campaign from several beginnings")
def test_a_small_mass_on_every_sensor_is_begun_at_the_frequencies(rig, make):
    prepared = prepare(make(Effect(effect="sensor_mass", parameters={"mass_each": 0.001}, place={"x": "all"})))
    bench = bench_of(prepared, prepared.blocks, free_of(prepared.campaign), lambda _: True)
    (candidate,) = (c for c in of_bench(rig) if c.effect == "sensor_mass")
    # Thickness, density and Young's modulus have done the work, and the effect looks like next to nothing.
    u = np.append(baseline(bench).u, candidate.slots[0].coordinate(1.4e-4))
    found = ended(bench, seen(Problem(bench.thin, bench.free, (candidate,)), u), 0.0, 100.0)
    assert found.gap < 1.1
    np.testing.assert_allclose(found.effects[0].parameters["mass_each"], 0.001, rtol=0.01)


@pytest.mark.thorough("fits a whole campaign from several beginnings")
def test_masses_that_every_sensor_has_are_one_number_again(rig, make):
    rough = rig.model_copy(update={"tolerance": Tolerance.usual()})
    heavy = make(Effect(effect="sensor_mass", parameters={"mass_each": 0.008}, place={"x": "all"}))
    prepared = prepare(replace(heavy, rig=rough))
    whole = bench_of(prepared, prepared.blocks, free_of(prepared.campaign), lambda _: True)
    bench, free = replace(whole, data=whole.thin), whole.free
    (candidate,) = (c for c in of_bench(rough) if c.effect == "sensor_mass")
    # The assembly has done the work by numbers that no bench has, and the effect looks like next to nothing.
    bent = [8.0 if t.tolerance == "sensor_mass_kg" else 0.0 for t in free.deviations]
    u = np.append(np.zeros(free.size), candidate.slots[0].coordinate(1e-4))
    u[free.first_deviation : free.first_deviation + len(bent)] = bent
    problem = Problem(bench.thin, free, (candidate,))
    r = problem.residual(u)
    found = ended(bench, Fit(problem, u, float(r @ r), r, np.eye(len(u))), COARSE / 30, 2.0)
    assert found.gap < 1.1
    assert ordinary(found)
    np.testing.assert_allclose(found.effects[0].parameters["mass_each"], 0.008, rtol=0.3)


LOUD = Effect(effect="gain_error", parameters={"gain": 1.6}, place={"channel": 3})


def loud(rig, make, effect):
    """A bench as built of which one channel reads too much, and a short fit of another effect or of that one."""
    prepared = prepare(replace(make(LOUD), rig=rig.model_copy(update={"tolerance": Tolerance.usual()})))
    whole = bench_of(prepared, prepared.blocks, free_of(prepared.campaign), lambda _: True)
    bench = replace(whole, data=whole.thin)
    listed = pool(bench, seen(Problem(bench.thin, bench.free, ()), np.zeros(bench.free.size)))
    candidate = next(c for c in listed if c.effect == effect and dict(c.place).get("channel", 3) == 3)
    own = [s.coordinate(s.starts[0]) for s in candidate.slots]
    # The fit before has bent the assembly a little.
    u = np.append(np.full(bench.free.size, 0.5), own)
    return bench, short(bench, (candidate,), u, COARSE)


def test_two_beginnings_that_differ_or_leave_little_say_nothing(rig, make):
    bench, fit = loud(rig, make, "shaker_mass")
    much, more, little = (replace(fit, residual=np.full(100, left)) for left in (300.0, 500.0, 3.0))
    assert ending.far_alike(bench, much, replace(much, residual=np.full(100, 320.0)))
    assert not ending.far_alike(bench, much, more)
    assert not ending.far_alike(bench, little, little)


@pytest.mark.thorough("fits a whole campaign from several beginnings")
def test_what_takes_half_of_the_gap_is_followed_though_others_that_were_finished_leave_less(rig, make):
    bench, right = loud(rig, make, "gain_error")
    _, wrong = loud(rig, make, "shaker_mass")
    base = on_all(bench, short(bench, (), np.zeros(bench.free.size), COARSE))
    with ThreadPoolExecutor(2) as workers:
        (followed,) = taking_half(bench, base, [wrong, right], COARSE / 12, workers, 2)
    assert [e.effect for e in followed.effects] == ["gain_error"]
    assert excess(followed) < 0.01 * excess(base)
