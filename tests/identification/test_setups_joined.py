"""Several set-ups of one test: compared by what they share, joined into one model."""

import numpy as np
import pytest

from modallab.core.errors import DataError, IdentificationError
from modallab.core.model import ModalModel
from modallab.identification.setups.compare import compare_setups
from modallab.identification.setups.found import SetUpModel, same_modes
from modallab.identification.setups.join import join_setups, require_same_points, weighted_mean
from modallab.identification.setups.readings import readings_of_setups

FREQUENCY = np.array([5.0, 31.0, 88.0])
PHI = np.array([np.sin(k * np.linspace(0.3, 1.4, 10)) + 0.1 * k for k in (1, 2, 3)])
SIGMA = 1e-4


def setup(name: str, points: dict[str, int], *, shift: float = 0.0, gain: float = 1.0, kg: float = 0.0) -> SetUpModel:
    """A set-up struck at points 10 and 3, with sensors of a mass."""
    rows, struck = [p - 1 for p in points.values()], [9, 2]
    constants = gain * PHI[:, rows, None] * PHI[:, None, struck] + 0j
    size = np.full(3, np.nan)
    model = ModalModel(
        method="plscf",
        test="impact",
        band_hz=(2.0, 200.0),
        frequency_hz=FREQUENCY * (1 + shift),
        damping_ratio=np.full(3, 0.01),
        frequency_sigma_hz=1e-5 * FREQUENCY,
        damping_sigma=np.full(3, 1e-5),
        outputs=tuple(points),
        output_points=tuple(points.values()),
        input_points=(10, 3),
        modal_constants=constants,
        modal_constant_sigma=np.full(constants.shape, SIGMA),
        residuals=np.zeros((0, *constants.shape[1:])),
        half_power=size,
        half_power_floor=size,
    )
    return SetUpModel(name, model, (kg,) * len(points))


LEFT, RIGHT = {"ref": 10, "a": 1, "b": 2}, {"ref": 10, "a": 3, "b": 4}


def test_set_ups_that_agree_are_one_model_with_every_point() -> None:
    found = (setup("left", LEFT), setup("right", RIGHT))
    modes = same_modes(found)
    compared = compare_setups(found, modes)
    model = join_setups(found, modes, compared)
    assert not any(item.off for item in compared)
    assert model.outputs == ("a@1", "b@2", "a@3", "b@4", "ref@10")
    np.testing.assert_allclose(np.abs(model.shapes), np.abs(PHI[:, [0, 1, 2, 3, 9]]), rtol=1e-6)
    np.testing.assert_allclose(model.frequency_sigma_hz, 1e-5 * FREQUENCY)


def test_the_one_that_is_off_is_named_with_its_mass_and_the_sigma_grows() -> None:
    other = {"ref": 10, "a": 5, "b": 6}
    found = (setup("left", LEFT), setup("middle", other), setup("right", RIGHT, shift=-0.0012, kg=0.005))
    modes = same_modes(found)
    compared = compare_setups(found, modes)
    model = join_setups(found, modes, compared)
    assert [item.name for item in compared if item.off] == ["right"]
    assert compared[2].shift_sigmas[1] == pytest.approx(-120 / np.sqrt(2), rel=0.01)
    (said,) = compared[2].words()
    assert "set-up right: mode" in said
    assert "is 0.12 % lower than in left (85 sigmas), and 2 more modes differ: the mass of a, b (10 g) moved" in said
    assert any("Set-ups that are off: right." in note for note in model.notes)
    assert np.all(np.abs(model.frequency_hz - FREQUENCY * 0.9988) < 2 * model.frequency_sigma_hz)
    read = readings_of_setups(found, modes, compared)
    assert [bool(item.off.all()) for item in read] == [False, False, True]
    np.testing.assert_allclose(read[2].frequency_hz, FREQUENCY * 0.9988)


def test_set_ups_struck_elsewhere_are_named_with_their_points() -> None:
    with pytest.raises(DataError, match="set-up left was struck at points 10, 3, set-up right at points 10, 6"):
        require_same_points([("left", (10, 3)), ("right", (10, 6))])


def test_a_gain_that_changed_is_seen_by_the_reference_and_taken_out() -> None:
    found = (setup("left", LEFT), setup("right", RIGHT, gain=1.1))
    modes = same_modes(found)
    compared = compare_setups(found, modes)
    np.testing.assert_allclose(compared[1].ratio, 1.1)
    assert any("the reference reads mode 1 +10 %" in words for words in compared[1].words())
    model = join_setups(found, modes, compared)
    np.testing.assert_allclose(np.abs(model.shapes), np.abs(PHI[:, [0, 1, 2, 3, 9]]), rtol=1e-6)


def test_without_a_sensor_that_stays_reciprocity_compares() -> None:
    found = (setup("left", {"a": 10, "b": 1}), setup("right", {"a": 3, "b": 4}, gain=1.1))
    (_, right) = compare_setups(found, same_modes(found))
    np.testing.assert_allclose(right.ratio, 1.1)


def test_set_ups_with_no_mode_in_common_are_not_joined() -> None:
    with pytest.raises(IdentificationError, match="left, right"):
        same_modes((setup("left", LEFT), setup("right", RIGHT, shift=0.3)))


def test_the_scatter_between_set_ups_is_zero_where_they_agree() -> None:
    values, sigmas = np.array([[5.0], [5.0], [5.03]]), np.full((3, 1), 0.01)
    agreed, sigma = weighted_mean(np.full((3, 1), 5.0), sigmas)
    assert (agreed[0], sigma[0]) == (5.0, 0.01)
    assert weighted_mean(values, sigmas)[1][0] > 0.015
