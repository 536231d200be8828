"""Counts become SI units by the rig's sensitivities, and the end of the range is known."""

import numpy as np
import pytest

from modallab.bench.protocol import DeliveredSampling
from modallab.core.errors import DataError, RigError
from modallab.core.rig import Channel, Converter, Rig
from modallab.core.units import Test
from modallab.signals.conversion import Conversion, largest_magnitudes


def rig(**response: object) -> Rig:
    force = Channel(
        index=0, name="force", quantity="force", unit="N", sensitivity_v_per_unit={"impact": 0.02, "sine": 0.5}
    )
    second = {"index": 1, "name": "a01", "quantity": "acceleration", "unit": "g", "sensitivity_v_per_unit": 0.1}
    return Rig(
        name="r", model="unknown", channels=(force, Channel.model_validate(second | response)), converter=Converter()
    )


def delivery(units: tuple[str, str] = ("V", "V"), scale: float = 10 / 2**15) -> DeliveredSampling:
    return DeliveredSampling(2000.0, 2000.0, 2000.0, np.dtype(np.int16), np.full(2, scale), units)


def conversion_of(rig: Rig, delivery: DeliveredSampling, test: Test) -> Conversion:
    return Conversion.of(rig, test, delivery.units, delivery.scale, delivery.dtype)


def test_volts_are_scaled_by_the_sensitivity_of_the_test_and_the_unit() -> None:
    impact = conversion_of(rig(), delivery(), "impact")
    np.testing.assert_allclose(impact.si_per_count, [10 / 2**15 / 0.02, 10 / 2**15 / 0.1 * 9.80665])
    assert conversion_of(rig(), delivery(), "sine").si_per_count[0] == pytest.approx(10 / 2**15 / 0.5)


def test_millivolts_and_engineering_units_are_understood() -> None:
    conversion = conversion_of(rig(), delivery(("mV", "m/s^2"), 1.0), "impact")
    np.testing.assert_allclose(conversion.si_per_count, [1e-3 / 0.02, 1.0])
    assert conversion.full_scale[1] == pytest.approx(32767)


def test_both_ends_of_the_converter_are_overload_and_nothing_else() -> None:
    conversion = conversion_of(rig(), delivery(), "impact")
    for value, over in [(32767, True), (-32768, True), (32766, False), (-32766, False)]:
        assert conversion.overloaded_channels(np.array([[0, 0], [0, value]], dtype=np.int16)).tolist() == [False, over]


def test_a_channels_own_range_counts_before_the_converters() -> None:
    conversion = conversion_of(rig(range_v=5.0), delivery(), "impact")
    assert conversion.full_scale[1] == pytest.approx(2**14, rel=1e-3)


def test_the_most_negative_count_has_its_magnitude() -> None:
    assert largest_magnitudes(np.array([[-32768, 5]], dtype=np.int16)).tolist() == [32768.0]


def test_a_missing_sensitivity_and_a_wrong_unit_name_the_channel() -> None:
    with pytest.raises(RigError, match="a01"):
        conversion_of(rig(sensitivity_v_per_unit={"sine": 1.0}), delivery(), "impact")
    with pytest.raises(DataError, match="a01"):
        conversion_of(rig(), delivery(("V", "N")), "impact")
