"""A fit whose number ran to an end of its range finds back to where the data want it."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effect import AllAlongBeam
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.model.candidates import channel_candidates
from modallab.gap.model.fit import Problem, fit_at
from modallab.gap.report.initial_gap import nuisances_of_campaign, problem_of_records
from modallab.gap.search.fitting import complete_fit, short_fit
from modallab.gap.unknown.fitted import element


@pytest.mark.parametrize(
    "hz", [300.0, pytest.param(430.0, marks=pytest.mark.thorough("fits once more from the other side"))]
)
def test_a_mount_with_too_much_damping_becomes_a_resonance_again(
    rig: Rig, make: Callable[..., Campaign], hz: float
) -> None:
    mount = Effect(effect="loose_mount", parameters={"hz": 382.0, "zeta": 0.075}, place={"channel": 6})
    prepared = prepare_campaign(make(mount, tests=("impact",)))
    bench = problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: True)
    (candidate,) = (c for c in channel_candidates(rig, 6) if c.effect == "loose_mount")
    own = [slot.coordinate(value) for slot, value in zip(candidate.slots, (hz, 0.399), strict=True)]
    begun = short_fit(bench, (candidate,), np.array([*np.zeros(bench.free.size), *own]), 0.1)
    found = complete_fit(bench, begun, 0.01)
    assert found.gap < 1.1
    assert found.effects[0].parameters["hz"] == pytest.approx(382.0, rel=1e-3)


def test_a_beam_pressed_beyond_its_buckling_load_is_a_bad_fit_and_no_failure(
    rig: Rig, make: Callable[..., Campaign]
) -> None:
    prepared = prepare_campaign(make())
    bench = problem_of_records(prepared, prepared.blocks, nuisances_of_campaign(prepared.campaign), lambda _: True)
    law = element(bench, "beam_law", ("tension",), AllAlongBeam(), 1.0)
    problem, beam = Problem(bench.thin, bench.free, (law,)), rig.beam
    assert beam is not None
    bending = beam.youngs_modulus_pa * beam.width_m * beam.thickness_m**3 / 12
    buckling = np.pi**2 * bending / (2 * beam.length_m) ** 2

    def cost(tension: float) -> float:
        own = [slot.coordinate(tension) for slot in law.slots]
        return fit_at(problem, np.array([*np.zeros(bench.free.size), *own])).cost

    assert np.isfinite(cost(-1.1 * buckling))
    assert cost(-1.1 * buckling) > cost(-0.5 * buckling) > cost(0.0)
