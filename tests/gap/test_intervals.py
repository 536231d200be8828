"""How well the numbers of an effect are known: by the noise, the model's own error, and the tolerances."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig, Tolerance
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced, Weights
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.candidates import beam_candidates, channel_candidates
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.model.minimise import minimise
from modallab.gap.model.nuisances import nuisances
from modallab.gap.search.intervals import deviations, interval, intervals, relative_tolerance
from modallab.twin.candidate import FreeNumber

GAIN = 1.05


@pytest.fixture(scope="module")
def data(make: Callable[..., Campaign]) -> Reduced:
    campaign = make(Effect(effect="gain_error", parameters={"gain": GAIN}, place={"channel": 4}))
    prepared = prepare_campaign(campaign)
    return reduce_blocks(campaign, prepared.blocks, Weights(prepared.noise_v))


def fitted(rig: Rig, data: Reduced) -> Fit:
    (gain,) = (c for c in channel_candidates(rig, 4) if c.effect == "gain_error")
    problem = Problem(data, nuisances(rig, 450.0), (gain,), 0.01)
    near = minimise(problem, np.concatenate([np.zeros(problem.free.size), [np.log(GAIN)]]), 6)
    return minimise(replace(problem, floor=0.0), near.u, 8, 1e-6)


def by_noise(fit: Fit) -> float:
    return float(np.sqrt(np.linalg.pinv(fit.normal, hermitian=True)[-1, -1])) * max(1.0, fit.gap)


def rippled(data: Reduced) -> Reduced:
    """The hits with channel 4 off by a little that changes slowly with frequency, as a connector or a cable does it."""

    def off(d):
        hz = d.source.lines / (d.source.n * d.source.dt)
        y = d.rows.y.copy()
        y[3] *= 1 + 0.01 * np.cos(hz / 60.0)
        return replace(d, rows=replace(d.rows, y=y))

    return replace(data, impacts=tuple(off(d) for d in data.impacts))


def test_noise_alone_leaves_less_than_the_expected_error_of_the_model(rig: Rig, data: Reduced) -> None:
    fit = fitted(rig, data)
    assert fit.gap < 1.1
    assert by_noise(fit) <= deviations(fit)[-1] < DEFAULT.expected_error
    assert abs(fit.effects[0].parameters["gain"] / GAIN - 1) < 4 * deviations(fit)[-1]


def test_what_no_effect_explains_widens_the_interval(rig: Rig, data: Reduced) -> None:
    assert deviations(fitted(rig, rippled(data)))[-1] > 1.5 * deviations(fitted(rig, data))[-1]


def test_of_a_factor_a_share_is_one_of_its_distance_from_none() -> None:
    factor = FreeNumber("gain", "log", (0.9, 1.1), low=0.1, high=5.0, none=1.0)
    low, high = interval(factor, factor.coordinate(1.075), 1e-6, 0.01 / 0.075)
    assert (low, high) == pytest.approx((1.075 - 0.0208, 1.075 + 0.0208), abs=1e-3)


def test_a_fit_is_as_sure_whatever_slopes_it_was_last_moved_by(rig: Rig, data: Reduced) -> None:
    fit = fitted(rig, data)
    again = replace(fit, normal=np.diag(np.linspace(0.1, 10.0, len(fit.u))) @ fit.normal)
    assert deviations(again) == pytest.approx(deviations(fit))


def test_of_a_gain_the_sensors_own_percent_is_nobodys_to_tell(rig: Rig) -> None:
    wrong = Effect(effect="gain_error", parameters={"gain": 1.1}, place={"channel": 4})
    stated = rig.model_copy(update={"tolerance": Tolerance(sensitivity=0.02)})
    assert relative_tolerance(wrong, stated) == pytest.approx(0.02 / 0.1)
    # Nothing is added where the rig file does not mention it, or where the tolerance is free beside the effect.
    assert relative_tolerance(wrong, rig.model_copy(update={"tolerance": Tolerance(youngs_modulus=0.01)})) == 0.0
    damper = Effect(effect="local_damper", parameters={"c": 9.0}, place={"x": 0.5})
    assert relative_tolerance(damper, rig.model_copy(update={"tolerance": Tolerance.usual()})) == 0.0


@pytest.mark.parametrize("x", [0.0, 0.5])
def test_a_place_is_known_no_better_than_the_effect_explains_the_gap(rig: Rig, data: Reduced, x: float) -> None:
    (mass,) = (c for c in beam_candidates(rig) if c.effect == "added_mass")
    free = nuisances(rig, 450.0)
    at = dict(zip([s.name for s in mass.slots], [np.log(0.05), x], strict=True))
    wrong = fit_at(Problem(data, free, (mass,)), np.concatenate([np.zeros(free.size), list(at.values())]))
    (believed,) = intervals(wrong)
    within = believed.within["x"]
    # It explains nothing: the place is open over a tenth of the beam at least, thousands of times what noise leaves.
    assert within is None or within[1] - within[0] > 0.1
