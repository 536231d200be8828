import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.verification.comparison import compare_shapes

RNG = np.random.default_rng(1)
SHAPES = RNG.choice([-1.0, 1.0], (3, 6)) * RNG.uniform(0.8, 1.2, (3, 6))


def model(shapes=SHAPES, frequency=(5.0, 30.0, 80.0), points=(1, 2, 3, 4, 5, 6), scale=1.0):
    n = len(frequency)
    constants = scale * np.asarray(shapes, complex)[:, :, None]
    return ModalModel(
        method="plscf",
        band_hz=(1.0, 100.0),
        frequency_hz=np.array(frequency),
        damping_ratio=np.full(n, 0.01),
        frequency_sigma_hz=np.zeros(n),
        damping_sigma=np.zeros(n),
        outputs=tuple(f"a{p}" for p in range(len(points))),
        output_points=points,
        input_points=(1,),
        modal_constants=constants,
        modal_constant_sigma=np.zeros(constants.shape),
        residuals=np.zeros((0, len(points), 1)),
        half_power=np.full(n, np.nan),
        half_power_floor=np.full(n, np.nan),
    )


def test_the_same_shapes_agree_whatever_their_scale():
    found = compare_shapes(model(), model(scale=-3.0 + 1j, frequency=(5.01, 30.2, 79.9)))
    assert found.pairs == ((0, 0), (1, 1), (2, 2))
    np.testing.assert_allclose(found.mac, 1)
    np.testing.assert_allclose(found.comac, 1)


def test_a_wrong_sensor_shows_at_its_point_alone():
    wrong = SHAPES.copy()
    wrong[:, 3] *= [0.1, 1.0, 1.5]
    found = compare_shapes(model(), model(wrong))
    assert np.argmin(found.comac) == 3
    assert found.comac[3] < 0.9 < np.delete(found.comac, 3).min()


def test_only_shared_modes_and_points_are_compared():
    order = [2, 0, 5, 1]
    other = model(SHAPES[1:][:, order], (30.1, 81.0), tuple(o + 1 for o in order))
    found = compare_shapes(model(), other)
    assert found.pairs == ((1, 0), (2, 1))
    assert found.points == (1, 2, 3, 6)
    np.testing.assert_allclose(found.mac, 1)


def test_models_with_nothing_in_common_are_rejected():
    with pytest.raises(DataError, match="no mode"):
        compare_shapes(model(), model(frequency=(11.0, 45.0, 99.0)))
    with pytest.raises(DataError, match="0 points"):
        compare_shapes(model(), model(points=(11, 12, 13, 14, 15, 16)))
    with pytest.raises(DataError, match="0 points"):
        compare_shapes(model(), model(points=(None,) * 6))
