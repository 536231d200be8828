"""Linear effects found by modal rows beside an assembly whose tolerances could do the work of an effect."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.core.rig import Tolerance
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.inference.baseline import baseline
from modallab.gap.inference.select import StepwiseSelection
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.choose import select_explanation
from modallab.gap.search.clock import clock_error_visible, fit_with_clock
from modallab.gap.search.consequence import without_inconsequential
from modallab.gap.search.fitting import Bench
from modallab.twin.effects import search_of

USUAL = Tolerance.usual()


def assembled(rig, make, *effects, allowed=None, **more) -> Bench:
    """A bench whose rig file states a lab's usual tolerances; its first look at the data is all of the data."""
    names = {e.effect for e in effects} if allowed is None else allowed
    prepared = prepare_campaign(replace(make(*effects, **more), rig=rig.model_copy(update={"tolerance": USUAL})))
    whole = problem_of_records(
        prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda name: name in names
    )
    return replace(whole, data=whole.thin)


def best(bench: Bench):
    """The explanation that stays after all rounds."""
    return select_explanation(bench, StepwiseSelection(bench, baseline(bench)).rounds()).fit


@pytest.mark.thorough("fits a whole campaign with many numbers of the assembly")
@pytest.mark.parametrize(
    ("effect", "parameters", "place", "others", "within"),
    [
        ("sensor_mass", {"mass_each": 0.008}, {"x": "all"}, ("ground_spring",), 0.3),
        ("force_gain", {"gain": 1.075}, {"channel": 0}, ("ac_coupling",), 0.05),
        ("shaker_mass", {"mass": 0.02}, {"x": 0.4}, ("added_mass",), 0.1),
        ("stinger_moment", {"k_rot": 13.0}, {"x": 0.4}, ("clamp_rotation",), 0.1),
    ],
)
def test_an_effect_that_tolerances_could_take_over_is_found_with_its_size(
    rig, make, effect, parameters, place, others, within
):
    there = Effect(effect=effect, parameters=parameters, place=place)
    # A shaker hangs on the beam in a sine test only, and hits say what the beam is without it.
    tests = ("impact", "sine") if "x" in place and place["x"] != "all" else ("impact",)
    found = best(assembled(rig, make, there, allowed={effect, *others}, tests=tests))
    assert [e.effect for e in found.effects] == [effect]
    ((name, value),) = parameters.items()
    np.testing.assert_allclose(found.effects[0].parameters[name], value, rtol=within)


@pytest.mark.thorough("fits a whole campaign with many numbers of the assembly")
def test_hits_beside_their_points_do_not_hide_a_mass(rig, make):
    beside = Effect(effect="hit_position", parameters={"dx": -0.09}, place={"where": "hit"})
    heavy = Effect(effect="added_mass", parameters={"mass": 0.2}, place={"x": 0.97})
    found = {e.effect: e for e in best(assembled(rig, make, beside, heavy, tests=("impact",))).effects}
    assert set(found) == {"added_mass", "hit_position"}
    np.testing.assert_allclose(found["added_mass"].parameters["mass"], 0.2, rtol=0.05)
    np.testing.assert_allclose(found["hit_position"].parameters["dx"], -0.09, rtol=0.05)


@pytest.mark.thorough("fits a whole campaign with many numbers of the assembly")
@pytest.mark.parametrize(("gain", "named"), [(-0.995, "polarity"), (-0.8, "gain_error"), (0.8, "gain_error")])
def test_a_gain_near_minus_one_is_a_wrong_sign(rig, make, gain, named):
    wrong = Effect(effect="gain_error", parameters={"gain": gain}, place={"channel": 3})
    found = best(assembled(rig, make, wrong, allowed={"gain_error", "polarity"}, tests=("impact",)))
    assert [(e.effect, e.place.model_dump()) for e in found.effects] == [(named, {"channel": 3})]


@pytest.mark.thorough("fits a whole campaign with many numbers of the assembly")
@pytest.mark.parametrize(("relative", "named"), [(-6e-4, True), (-1e-4, False)])
def test_a_clock_that_the_generators_lines_show_is_no_matter_of_the_beam(rig, make, relative, named):
    slow = Effect(effect="clock_error", parameters={"relative": relative}, place={"channel": "all"})
    bench = assembled(rig, make, slow)
    assert bench.data.sines is not None
    # The twin's generator goes by the recorder's clock; a real one has a quartz of its own.
    lines = replace(bench.data.sines, ratio=1 / (1 + relative))
    bench = replace(bench, data=replace(bench.data, sines=lines))
    found = fit_with_clock(bench, baseline(bench))
    assert clock_error_visible(bench) is named
    assert (found is not None) is named
    if found is not None:
        kept, dismissed = without_inconsequential(found, bench.data, clock_visible=True)
        assert [e.effect for e in kept.effects] == ["clock_error"]
        assert dismissed == []
        np.testing.assert_allclose(kept.effects[0].parameters["relative"], relative, rtol=0.2)


def test_a_turned_channel_with_an_ordinary_sensitivity_is_a_polarity(rig):
    usual = rig.model_copy(update={"tolerance": USUAL})
    turned = Effect(effect="gain_error", parameters={"gain": -1.017}, place={"channel": 3})
    distance = search_of("gain_error").tolerance.deviations_from
    assert distance(turned, "polarity", usual) == pytest.approx(1.7)
    assert distance(turned.model_copy(update={"parameters": {"gain": -0.3}}), "polarity", usual) > 50
    assert distance(turned, "position_error", usual) == np.inf
