"""Effects that the assembly does as well, large effects, and wrong clocks that a beam could stand in for."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.core.rig import Tolerance
from modallab.gap.conditioning.prepare import prepare
from modallab.gap.model.candidates import of_bench
from modallab.gap.model.fit import Problem, seen
from modallab.gap.model.prefit import start
from modallab.gap.report.initial_gap import bench_of, free_of
from modallab.gap.search.beside_hits import beside_the_hits, only_sines
from modallab.gap.search.by_frequencies import round_by_frequencies, smaller
from modallab.gap.search.by_relief import FORGIVEN
from modallab.gap.search.clock import clock_shows, with_clock
from modallab.gap.search.explain import from_one_test, rounds
from modallab.gap.search.fitting import COARSE, annealed, baseline, ordinary, short
from modallab.gap.search.halving import annealed_together
from modallab.gap.search.pool import pool
from modallab.gap.search.screen import Screen
from modallab.gap.search.worth import worthwhile
from modallab.twin.effects import search_of


def assembled(rig, make, effect, allowed=lambda _: True):
    """A bench whose rig file states a lab's usual tolerances; its first look at the data is all of the data."""
    effects = effect if isinstance(effect, tuple) else (effect,)
    prepared = prepare(replace(make(*effects), rig=rig.model_copy(update={"tolerance": Tolerance.usual()})))
    whole = bench_of(prepared, prepared.blocks, free_of(prepared.campaign), allowed)
    return replace(whole, data=whole.thin)


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
def test_what_the_assembly_does_as_well_is_found_by_the_frequencies(rig, make):
    heavy = Effect(effect="sensor_mass", parameters={"mass_each": 0.008}, place={"x": "all"})
    bench = assembled(rig, make, heavy, lambda name: name == "sensor_mass")
    bent = [8.0 if t.tolerance == "sensor_mass_kg" else 0.0 for t in bench.free.deviations]
    u = np.zeros(bench.free.size)
    u[bench.free.first_deviation : bench.free.first_deviation + len(bent)] = bent
    best = round_by_frequencies(bench, seen(Problem(bench.thin, bench.free, ()), u)).fits[0]
    assert [e.effect for e in best.effects] == ["sensor_mass"]
    assert ordinary(best)
    np.testing.assert_allclose(best.effects[0].parameters["mass_each"], 0.008, rtol=0.3)


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
def test_side_by_side_the_best_ends_where_it_does_alone(rig, make):
    heavy = Effect(effect="sensor_mass", parameters={"mass_each": 0.008}, place={"x": "all"})
    listed = ("sensor_mass", "ground_spring")
    bench = assembled(rig, make, heavy, lambda name: name in listed)
    own = pool(bench, seen(Problem(bench.thin, bench.free, ()), np.zeros(bench.free.size)))
    begins = [start((c,), [s.coordinate(s.starts[0]) for s in c.slots], bench.free, bench.poles).u for c in own]
    fits = [short(bench, (c,), u, COARSE) for c, u in zip(own, begins, strict=True)]
    with ThreadPoolExecutor(2) as workers:
        best, other = annealed_together(bench, fits, COARSE / 6, workers, kept=1, most=1)
    (own,) = best.effects
    assert own.effect == "sensor_mass"
    (alone,) = [annealed(bench, f, COARSE / 6) for f in fits if f.effects[0].effect == "sensor_mass"]
    np.testing.assert_allclose(best.u, alone.u, atol=1e-9)
    # What was let go on the way says what it leaves all the same, by fewer slopes than would bring it to its end.
    assert other.cost == pytest.approx(seen(other.problem, other.u).cost)
    assert other.cost > 1.5 * best.cost


def test_the_gain_that_all_sensitivities_do_as_well_relieves_them_most(rig, make):
    strong = Effect(effect="force_gain", parameters={"gain": 1.075}, place={"channel": 0})
    bench = assembled(rig, make, strong, lambda name: name in ("force_gain", "ac_coupling"))
    # Every sensor a little low is what a strong force is.
    bent = short(bench, (), np.zeros(bench.free.size), COARSE).u
    gains = 3 + bench.free.modes
    bent[gains : gains + 11] = [-4.0] * 10 + [3.5]
    fit = seen(Problem(bench.thin, bench.free, ()), bent)
    screen = Screen(replace(fit.problem, floor=FORGIVEN), bent, bench.poles, relieved=True)
    begins = sorted((screen.begins(c)[0] for c in pool(bench, fit)), key=lambda b: b.cost)
    (likeliest,) = begins[0].problem.candidates
    assert likeliest.effect == "force_gain"
    assert 1.02 < likeliest.slots[0].value(begins[0].u[-1]) < 1.15
    assert begins[0].cost < begins[1].cost - 10


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
def test_what_hangs_on_the_beam_with_the_shaker_is_found_beside_the_beam_of_the_hits(rig, make):
    heavy = Effect(effect="shaker_mass", parameters={"mass": 0.02}, place={"x": 0.4})
    found = beside_the_hits(assembled(rig, make, heavy, lambda name: name == "shaker_mass"))
    assert found is not None
    assert [e.effect for e in found.effects] == ["shaker_mass"]
    np.testing.assert_allclose(found.effects[0].parameters["mass"], 0.02, rtol=0.1)


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
@pytest.mark.parametrize("stiffness", [13.0, 28.6])
def test_a_size_between_the_first_ones_is_found_beside_the_hits(rig, make, stiffness):
    stiff = Effect(effect="stinger_moment", parameters={"k_rot": stiffness}, place={"x": 0.4})
    found = beside_the_hits(assembled(rig, make, stiff, lambda name: name == "stinger_moment"))
    assert found is not None
    np.testing.assert_allclose(found.effects[0].parameters["k_rot"], stiffness, rtol=0.1)


@pytest.mark.parametrize(("effect", "value"), [("sensor_mass", 4e-3), ("stinger_moment", 30.0)])
def test_smaller_sizes_are_the_next_smaller_ones(rig, make, effect, value):
    (candidate,) = (c for c in of_bench(make().rig) if c.effect == effect)
    (slot,) = candidate.slots
    less = [slot.value(u) for u in smaller(candidate, np.array([slot.coordinate(value)]))]
    assert less == pytest.approx(sorted((v for v in slot.starts if v < value), reverse=True)[:2])


def test_a_soft_root_smaller_as_an_effect_is_a_stiffer_one(rig, make):
    (candidate,) = (c for c in of_bench(make().rig) if c.effect == "clamp_rotation")
    (slot,) = candidate.slots
    at = len(slot.starts) // 2
    first, second = sorted(slot.starts)[at : at + 2]
    less = smaller(candidate, np.array([slot.coordinate(0.99 * first)]))
    assert [slot.value(u) for u in less] == pytest.approx([first, second])


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
def test_hits_beside_their_points_do_not_hide_what_the_sines_show(rig, make):
    beside = Effect(effect="hit_position", parameters={"dx": -0.09}, place={"where": "hit"})
    heavy = Effect(effect="added_mass", parameters={"mass": 0.2}, place={"x": 0.97})
    bench = assembled(rig, make, (beside, heavy), lambda name: name in ("added_mass", "hit_position"))
    found = from_one_test(bench, only_sines(bench))
    assert found is not None
    assert [e.effect for e in found.effects] == ["added_mass"]
    np.testing.assert_allclose(found.effects[0].parameters["mass"], 0.2, rtol=0.05)
    (level,) = rounds(bench, found, 1)
    assert [e.effect for e in level.fits[0].effects] == ["added_mass", "hit_position"]
    np.testing.assert_allclose(level.fits[0].effects[1].parameters["dx"], -0.09, rtol=0.05)


def test_nothing_is_looked_for_beside_hits_that_an_ordinary_bench_does_not_explain(rig, make):
    heavy = Effect(effect="added_mass", parameters={"mass": 0.1}, place={"x": 0.6})
    assert beside_the_hits(assembled(rig, make, heavy)) is None


def test_a_large_effect_begins_at_two_sizes_and_one_is_near_its_own(rig, make):
    stiff = Effect(effect="stinger_moment", parameters={"k_rot": 40.0}, place={"x": 0.4})
    bench = assembled(rig, make, stiff)
    (candidate,) = (c for c in of_bench(bench.data.rig) if c.effect == "stinger_moment")
    begin = short(bench, (), np.zeros(bench.free.size), COARSE)
    screen = Screen(Problem(bench.thin, bench.free, (), COARSE), begin.u, bench.poles)
    sizes = [candidate.slots[0].value(b.u[-1]) for b in screen.begins(candidate)]
    assert any(20 < size < 80 for size in sizes)
    assert max(sizes) > 4 * min(sizes)


@pytest.mark.thorough("looks for an effect beside an assembly of many numbers")
@pytest.mark.parametrize(("relative", "named"), [(-6e-4, True), (3e-4, True), (-1e-4, False)])
def test_a_clock_that_the_generators_lines_show_is_no_matter_of_the_beam(rig, make, relative, named):
    slow = Effect(effect="clock_error", parameters={"relative": relative}, place={"channel": "all"})
    bench = assembled(rig, make, slow)
    assert bench.data.sines is not None
    # The twin's generator goes by the recorder's clock; a real one has a quartz of its own.
    lines = replace(bench.data.sines, ratio=1 / (1 + relative))
    bench = replace(bench, data=replace(bench.data, sines=lines))
    found = with_clock(bench, baseline(bench))
    assert clock_shows(bench) is named
    assert (found is not None) is named
    if found is not None:
        kept, dismissed = worthwhile(found, bench.data, shown=True)
        assert [e.effect for e in kept.effects] == ["clock_error"]
        assert dismissed == []
        np.testing.assert_allclose(kept.effects[0].parameters["relative"], relative, rtol=0.2)


def test_a_turned_channel_with_an_ordinary_sensitivity_is_a_polarity(rig):
    usual = rig.model_copy(update={"tolerance": Tolerance.usual()})
    turned = Effect(effect="gain_error", parameters={"gain": -1.017}, place={"channel": 3})
    distance = search_of("gain_error").deviations_from
    assert distance(turned, "polarity", usual) == pytest.approx(1.7)
    assert distance(turned.model_copy(update={"parameters": {"gain": -0.3}}), "polarity", usual) > 50
    assert distance(turned, "position_error", usual) == np.inf
