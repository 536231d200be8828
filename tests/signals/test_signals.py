import numpy as np
import pytest

from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Beam, Channel, Point, Rig
from modallab.core.units import STANDARD_GRAVITY
from modallab.signals.signals import to_signals, to_signals_of
from modallab.signals.transform import remove_mean

COUNTS = np.array([[0, 100, 0, 0, 0, 0, 0, 0], [1, 2, 3, 4, 5, 6, 7, 8]], dtype=np.int16)


def rig(**accelerometer):
    channels = (
        Channel(index=0, name="force", quantity="force", unit="N", sensitivity_v_per_unit=0.01),
        Channel(index=1, name="a01", quantity="acceleration", point=1, **{"unit": "m/s^2", **accelerometer}),
    )
    return Rig(name="two", model="unknown", points=(Point(id=1, x_m=0.1),), channels=channels)


def block(units=("V", "V"), rate_hz=1000.0, samples=COUNTS, test="impact", channels=("force", "a01")):
    return Block("r", test, 0, rate_hz, samples, np.array([1e-3, 1e-3]), units, channels)


def test_counts_become_newtons_and_metres_per_second_squared():
    found = to_signals(block(), rig(sensitivity_v_per_unit=0.005))
    assert found.force[1] == pytest.approx(100 * 1e-3 / 0.01)
    np.testing.assert_allclose(found.responses[0], COUNTS[1] * 1e-3 / 0.005)
    assert found.outputs == ("a01",)


@pytest.mark.parametrize(("unit", "factor"), [("g", STANDARD_GRAVITY), ("mm/s^2", 1e-3)])
def test_a_sensitivity_per_other_unit_ends_in_si(unit, factor):
    found = to_signals(block(), rig(sensitivity_v_per_unit=0.1, unit=unit))
    np.testing.assert_allclose(found.responses[0], COUNTS[1] * 1e-3 / 0.1 * factor)


def test_engineering_units_are_not_divided_by_the_sensitivity_again():
    found = to_signals(block(units=("kN", "mm/s^2")), rig(sensitivity_v_per_unit=0.1))
    assert found.force[1] == pytest.approx(100 * 1e-3 * 1e3)
    np.testing.assert_allclose(found.responses[0], COUNTS[1] * 1e-6)


def test_a_sensor_that_looks_backwards_is_turned_and_a_negative_sensitivity_is_its_own_sign():
    forward = to_signals(block(), rig(sensitivity_v_per_unit=0.1)).responses
    np.testing.assert_allclose(to_signals(block(), rig(sensitivity_v_per_unit=0.1, direction="-z")).responses, -forward)
    np.testing.assert_allclose(to_signals(block(), rig(sensitivity_v_per_unit=-0.1)).responses, -forward)


def test_each_test_has_its_own_sensitivity():
    both = rig(sensitivity_v_per_unit={"impact": 0.1, "sine": 0.2})
    impact, sine = to_signals(block(), both), to_signals(block(test="sine"), both)
    np.testing.assert_allclose(impact.responses, 2 * sine.responses)


def test_a_sensor_across_the_drive_is_rejected_on_a_beam_and_taken_as_it_is_elsewhere():
    across = rig(direction="-x")
    elsewhere = to_signals(block(), across)
    np.testing.assert_array_equal(elsewhere.responses, to_signals(block(), rig()).responses)
    beam = Beam(length_m=1, width_m=0.05, thickness_m=0.01, youngs_modulus_pa=7e10, density_kg_m3=2700)
    with pytest.raises(DataError, match="measures along -x"):
        to_signals(block(), across.model_copy(update={"model": "cantilever", "beam": beam}))


@pytest.mark.parametrize(
    ("spoiled", "says"),
    [
        (block(channels=("force", "b01")), "are not the rig's"),
        (block(units=("V", "N")), "no unit of acceleration"),
        (block(rate_hz=0.0), "rate"),
        (block(rate_hz=np.nan), "rate"),
        (block(samples=COUNTS.T.copy()), "transposed"),
        (block(samples=np.where(np.arange(8) == 3, np.nan, COUNTS)), "NaN"),
        (block(samples=COUNTS[:, :0]), "empty"),
    ],
    ids=["names", "unit", "no rate", "nan rate", "transposed", "nan", "empty"],
)
def test_what_is_no_record_of_this_rig_is_rejected(spoiled, says):
    with pytest.raises(DataError, match=says):
        to_signals(spoiled, rig())


def test_blocks_of_one_test_share_rate_and_length():
    with pytest.raises(DataError, match="8 samples at 1000 Hz, 8 samples at 2000 Hz"):
        to_signals_of([block(), block(rate_hz=2000.0)], rig())


def test_the_mean_goes_and_nothing_else():
    values = np.random.default_rng(1).standard_normal((3, 64)) + 5
    found = remove_mean(values)
    np.testing.assert_allclose(found.mean(axis=1), 0, atol=1e-12)
    np.testing.assert_allclose(np.diff(found), np.diff(values))
    with pytest.raises(DataError, match="NaN"):
        remove_mean(np.array([1.0, np.nan]))
