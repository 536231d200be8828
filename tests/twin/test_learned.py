"""Learned elements in the twin do what their words say."""

import numpy as np
import pytest
from twin_campaign import bench, link

from modallab.core.effects import Effect
from modallab.twin.effects import apply_effect
from modallab.twin.modes import solve_modes

RIG = link()


def hz(*effects: Effect) -> np.ndarray:
    return solve_modes(bench(RIG, effects).structure).frequency_hz


def test_a_mass_on_a_stiff_spring_is_a_mass_on_the_beam() -> None:
    hung = Effect(effect="point_law", parameters={"hung_m": 0.1, "hung_hz": 20000.0}, place={"x": 0.7})
    rigid = Effect(effect="added_mass", parameters={"mass": 0.1}, place={"x": 0.7})
    assert hz(hung)[:6] == pytest.approx(hz(rigid)[:6], rel=1e-4)


def test_a_mass_on_a_soft_spring_adds_a_mode_at_its_own_resonance() -> None:
    hung = Effect(effect="point_law", parameters={"hung_m": 0.001, "hung_hz": 60.0}, place={"x": 0.7})
    assert np.min(np.abs(hz(hung) / 60.0 - 1)) < 0.01
    assert len(hz(hung)[hz(hung) < 400]) == len(hz()[hz() < 400]) + 1


def test_a_push_near_buckling_leaves_the_first_mode_next_to_no_frequency() -> None:
    assert RIG.beam is not None
    axial = RIG.beam.bending_stiffness_n_m2 / RIG.beam.length_m**2 * 2.06 / 2.05
    pushed = Effect(effect="beam_law", parameters={"tension": -0.999 * np.pi**2 / 4 * axial}, place={"x": "all"})
    assert hz(pushed)[0] < 0.05 * hz()[0]


def test_an_even_bedding_adds_the_same_square_to_every_frequency() -> None:
    assert RIG.beam is not None
    bedded = Effect(effect="beam_law", parameters={"bedding": 500.0}, place={"x": "all"})
    per_length = 7840.0 * RIG.beam.width_m * RIG.beam.thickness_m
    added = (hz(bedded)[:4] ** 2 - hz()[:4] ** 2) * (2 * np.pi) ** 2
    assert added == pytest.approx(np.full(4, 500.0 / per_length), rel=2e-3)


def test_an_operator_on_one_row_leaves_the_others() -> None:
    twin = bench(RIG, ())
    law = Effect(effect="row_filter", parameters={"gain": 0.5, "low_pass_hz": 80.0}, place={"channel": 4})
    chain = apply_effect(twin, law, RIG).chain
    assert chain.gain == {4: 0.5}
    assert chain.low_pass_hz == ((4, 80.0),)
