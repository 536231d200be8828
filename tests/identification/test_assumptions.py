from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_plscf import frf

from modallab.core.errors import DataError
from modallab.identification.selection.assumptions import (
    driving_point,
    linearity,
    proportional_damping,
    reciprocity,
    time_invariance,
)

PHI = np.random.default_rng(0).standard_normal((3, 6))
LINES = np.arange(20, 60, 0.02)


def measured(phi=PHI, frequency=(30.0, 40.0, 50.0), seed=None, quantity="mobility"):
    made = frf(list(frequency), [0.005] * 3, phi, [0, 3], LINES, quantity, seed=seed)
    return replace(made, output_points=(1, 2, 3, 4, 5, 6), input_points=(1, 4))


def test_one_linear_structure_passes_everything():
    assert reciprocity(measured()).holds
    assert linearity(measured(), measured()).value == 0
    assert time_invariance(measured(), measured()).holds
    assert driving_point(measured(quantity="inertance")).value == 0


@pytest.mark.parametrize("verdict", [linearity, time_invariance])
def test_a_frequency_that_moved_by_half_its_width_is_seen(verdict):
    found = verdict(measured(), measured(frequency=(30.0, 40.1, 50.0)))
    assert not found.holds
    assert found.value > 0.1
    assert f"{100 * found.value:.2g} %" in found.words


def test_noise_of_a_known_variance_is_no_change():
    one, other = (measured(seed=s) for s in (1, 2))
    # The noise is 1 % of the loudest FRFs' level, and so a tenth of the weakest's.
    assert not linearity(one, other).holds
    variance = np.full(one.values.shape, 1e-4 * np.mean(np.abs(measured().values) ** 2))
    assert linearity(replace(one, variance=variance), replace(other, variance=variance)).holds


def test_a_sensor_with_a_wrong_gain_breaks_reciprocity():
    good = measured()
    gain = np.where(np.arange(6) == 3, 1.2, 1.0)[:, None, None]
    assert not reciprocity(replace(good, values=good.values * gain)).holds


def test_a_turned_sensor_at_the_driving_point_is_seen():
    good = measured()
    found = driving_point(replace(good, values=-good.values))
    assert not found.holds


def model(constants, sigma=1e-4, parts=None):
    return SimpleNamespace(
        modal_constants=constants,
        modal_constant_sigma=np.full(constants.shape, sigma),
        modal_constant_part_sigma=parts,
        frequency_hz=np.arange(1, len(constants) + 1) * 10.0,
    )


def test_real_constants_are_proportional_and_a_travelling_wave_is_not():
    real = (PHI[:, :, None] * PHI[:, None, [0, 3]]).astype(complex)
    assert proportional_damping(model(real)).value == pytest.approx(0, abs=1e-6)
    wave = real * np.exp(1j * np.linspace(0, 1, 6))[:, None]
    found = proportional_damping(model(wave))
    assert not found.holds
    assert "degrees" in found.words


def test_phases_that_are_not_known_are_no_verdict_at_all():
    wave = (PHI[:, :, None] * PHI[:, None, [0, 3]]) * np.exp(1j * np.linspace(0, 0.4, 6))[:, None]
    with pytest.raises(DataError, match="cannot be said from these data"):
        proportional_damping(model(wave, sigma=2.0))


def test_noise_that_would_hide_any_change_is_no_verdict():
    one = measured()
    drowned = replace(one, variance=np.full(one.values.shape, np.mean(np.abs(one.values) ** 2)))
    for verdict in (lambda: linearity(drowned, drowned), lambda: reciprocity(drowned)):
        with pytest.raises(DataError, match="cannot be said from these data"):
            verdict()


def test_a_power_flow_that_noise_hides_is_no_verdict():
    one = measured()
    with pytest.raises(DataError, match="cannot be said from these data"):
        driving_point(replace(one, variance=np.full(one.values.shape, 1e6 * np.mean(np.abs(one.values) ** 2))))


def test_only_what_is_not_known_across_a_constant_hides_its_phase():
    wave = (PHI[:, :, None] * PHI[:, None, [0, 3]]) * np.exp(1j * np.linspace(-0.2, 0.2, 6))[:, None]
    size_unknown, time_unknown = (np.full(wave.shape, part) for part in (0.2 + 1e-4j, 1e-4 + 0.2j))
    turned = wave * 1j
    assert not proportional_damping(model(wave, 0.2, size_unknown)).holds
    assert proportional_damping(model(wave, 0.2, time_unknown)).holds
    assert proportional_damping(model(turned, 0.2, size_unknown)).holds
    assert not proportional_damping(model(turned, 0.2, time_unknown)).holds


@pytest.mark.parametrize(
    "wrong",
    [
        lambda g: linearity(g, replace(g, values=g.values[..., :-1], frequency_hz=g.frequency_hz[:-1])),
        lambda g: linearity(g, replace(g, values=g.values * np.nan)),
        lambda g: time_invariance(g, replace(g, input_points=(2, 4))),
        lambda g: reciprocity(replace(g, input_points=(None, 4))),
        lambda g: driving_point(replace(g, output_points=(None,) * 6)),
        lambda g: driving_point(replace(g, values=np.abs(g.values))),
        lambda g: proportional_damping(model(np.ones((2, 1, 1)) + 0j)),
    ],
    ids=["lines", "nan", "points", "no pair", "no driving point", "magnitude only", "one output"],
)
def test_what_cannot_be_judged_is_rejected(wrong):
    with pytest.raises(DataError):
        wrong(measured())
