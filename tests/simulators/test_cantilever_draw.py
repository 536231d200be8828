"""What the seed draws."""

import json
import math

import numpy as np

from modallab.core.plan import BLOCK_S
from modallab.core.rig import Rig, Tolerance
from modallab_simulators.cantilever import open_bench
from modallab_simulators.cantilever.beam import draw_beam, draw_clock, draw_damping


def test_the_first_mode_is_off_the_lines_of_the_block(rig: Rig):
    lines = np.array([draw_beam(s, rig.beam, rig.tolerance, 13.0).beam.omega(1)[0] for s in range(100)])
    lines *= BLOCK_S / (2 * math.pi)
    assert np.abs(lines - np.round(lines)).min() >= 0.1


def test_without_tolerance_the_beam_is_the_nominal_one(rig: Rig):
    exact = Tolerance(youngs_modulus=0, thickness=0, density=0)
    true = draw_beam(3, rig.beam, exact, 13.0)
    assert (true.youngs_modulus_pa, true.thickness_m) == (rig.beam.youngs_modulus_pa, rig.beam.thickness_m)


def test_draws_stay_within_three_tolerances_and_spread(rig: Rig):
    modulus = np.array([draw_beam(s, rig.beam, rig.tolerance, 13.0).youngs_modulus_pa for s in range(60)])
    relative = modulus / rig.beam.youngs_modulus_pa - 1
    assert np.abs(relative).max() < 3 * rig.tolerance.youngs_modulus + 1e-12
    assert 0.4 * rig.tolerance.youngs_modulus < relative.std() < 1.5 * rig.tolerance.youngs_modulus


def test_damping_is_between_0_3_and_1_percent_and_does_not_depend_on_how_many_are_drawn():
    zeta = np.array([draw_damping(s, 20, ()) for s in range(50)])
    assert zeta.min() >= 0.003
    assert zeta.max() <= 0.01
    assert zeta.std() > 0.001
    np.testing.assert_array_equal(draw_damping(5, 7, ()), draw_damping(5, 20, ())[:7])


def test_given_damping_replaces_the_drawn():
    np.testing.assert_array_equal(draw_damping(5, 4, (0.02,)), [0.02] * 4)
    np.testing.assert_array_equal(draw_damping(5, 4, (0.02, 0.01))[:2], [0.02, 0.01])
    np.testing.assert_array_equal(draw_damping(5, 4, (0.02, 0.01))[2:], draw_damping(5, 4, ())[2:])


def test_the_clock_is_off_by_up_to_20_ppm():
    clocks = np.array([draw_clock(s) for s in range(100)])
    assert 10e-6 < np.abs(clocks).max() <= 20e-6


def test_facts_state_the_truth_of_the_demonstration_bench(rig: Rig):
    facts = open_bench("sim://cantilever?seed=4", rig).info.facts
    f = json.loads(facts["frequency_hz"])
    np.testing.assert_allclose(f[:3], [4.8, 30.9, 87.8], rtol=0.04)
    assert f[-1] < 1000 < f[-1] * ((len(f) + 0.5) / (len(f) - 0.5)) ** 2 * 1.01
    assert len(json.loads(facts["damping_ratio"])) == len(f)
    shapes = np.array(json.loads(facts["shapes_per_sqrt_kg"]))
    assert shapes.shape == (len(f), len(rig.points))
    assert json.loads(facts["points"]) == [p.id for p in rig.points]
    true_mass = float(facts["density_kg_m3"]) * rig.beam.width_m * float(facts["thickness_m"]) * rig.beam.length_m
    # The tip of the first mode, in 1 / sqrt(mass): 2 for a rigid clamp, sqrt(3) for a hinge.
    assert math.sqrt(3) < abs(shapes[0, -1]) * math.sqrt(true_mass) < 2
    assert abs(float(facts["generator_ppm"])) <= 20
    assert float(facts["root_stiffness_nm_per_rad"]) > 0
