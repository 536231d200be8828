"""Overtones show where the force of a law acts, whatever the law is."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.overtones import harmonics_in_record
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.model.fit import Problem, fit_at
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.fitting import Bench
from modallab.gap.search.force_place import locate_by_overtones, place
from modallab.twin.effect_model import Acts
from modallab.twin.effects import model_of

CRACK = Effect(effect="breathing_crack", parameters={"EI_loss_open": 0.6}, place={"x": 0.31})
SPRING = Effect(effect="cubic_spring", parameters={"k3": 1e10}, place={"x": 0.8})


def bench(make: Callable[..., Campaign], *effects: Effect) -> Bench:
    prepared = prepare_campaign(make(*effects, tests=("sine",)))
    return problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: True)


@pytest.fixture(scope="module")
def cracked(make: Callable[..., Campaign]) -> Bench:
    return bench(make, CRACK)


def placed(on: Bench, acts: Acts) -> tuple[float, float]:
    """The place, and the share of the overtones that is left there, by the beam as believed."""
    twin = Problem(on.data, on.free).twin(np.zeros(on.free.size))
    found = place(on.overtones, [twin], on.data, acts)
    assert found is not None
    return found.x, found.left


def test_a_crack_bends_the_beam_at_its_place(cracked: Bench) -> None:
    x, left = placed(cracked, "couple")
    assert x == pytest.approx(0.31, abs=0.01)
    assert left < 0.05
    # No force on the beam makes such overtones.
    assert placed(cracked, "force")[1] > 2 * left


def test_a_spring_acts_at_its_place(make: Callable[..., Campaign]) -> None:
    x, left = placed(bench(make, SPRING), "force")
    assert x == pytest.approx(0.8, abs=0.02)
    assert left < 0.02


def test_a_law_is_looked_for_near_the_place_that_the_overtones_show(cracked: Bench) -> None:
    base = fit_at(Problem(cracked.data, cracked.free), np.zeros(cracked.free.size))
    begun = locate_by_overtones(cracked, base, model_of(CRACK.effect).candidates(cracked.data.rig)[0])
    (x,) = (s for s in begun.slots if s.name == "x")
    assert x.high - x.low < 0.1
    assert x.low < 0.31 < x.high


def test_a_channel_of_wrong_sign_does_not_hide_the_place(make: Callable[..., Campaign]) -> None:
    on = bench(make, SPRING, Effect(effect="polarity", parameters={"sign": -1.0}, place={"channel": 4}))
    base = fit_at(Problem(on.data, on.free), np.zeros(on.free.size))
    begun = locate_by_overtones(on, base, model_of(SPRING.effect).candidates(on.data.rig)[0])
    (x,) = (s for s in begun.slots if s.name == "x")
    assert x.low < 0.8 < x.high < x.low + 0.1


@pytest.mark.parametrize("hz", [40.0, 40.37])
def test_overtones_are_read_on_a_line_and_between_two(hz: float) -> None:
    t = np.arange(1024) / 1000.0
    wave = 3.0 * np.cos(2 * np.pi * hz * t + 0.3) + 0.2 * np.cos(4 * np.pi * hz * t - 1.0)
    second, third, *_ = harmonics_in_record("a", wave[None], 1000.0, hz)
    assert second.hz == pytest.approx(2 * hz)
    assert second.y[0] == pytest.approx(0.2 * np.exp(-1j), abs=1e-9)
    assert second.is_clear[0]
    assert abs(third.y[0]) < 1e-9
