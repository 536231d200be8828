import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.identification.selection.criteria import auto_mac, comac, mac, mpc, mpd

RNG = np.random.default_rng(1)
REAL = RNG.standard_normal((3, 8))
COMPLEX = REAL + 1j * RNG.standard_normal((3, 8))


def test_mac_is_one_for_any_factor_and_zero_across():
    np.testing.assert_allclose(np.diag(mac(COMPLEX, COMPLEX * (2 - 3j))), 1)
    assert mac(np.array([[1.0, 1.0]]), np.array([[1.0, -1.0]]))[0, 0] == 0
    assert mac(np.array([[1.0, 0.0]]), np.array([[1.0, 1.0]]))[0, 0] == pytest.approx(0.5)


def test_auto_mac_is_symmetric_and_sees_too_few_points():
    found = auto_mac(REAL)
    np.testing.assert_allclose(found, found.T)
    assert auto_mac(REAL[:, :1])[0, 1] == pytest.approx(1)


def test_comac_points_at_the_one_wrong_sensor():
    other = REAL * np.array([[2.0], [-1.0], [0.5]])
    np.testing.assert_allclose(comac(REAL, other), 1)
    other[1, 5] *= -4
    other[0, 5] *= 5
    assert np.argmin(comac(REAL, other)) == 5


def test_a_real_shape_is_a_line_whatever_its_phase():
    turned = REAL * np.exp(0.7j)
    np.testing.assert_allclose(mpc(turned), 1)
    np.testing.assert_allclose(mpd(turned), 0, atol=1e-6)


def test_a_shape_round_a_circle_has_no_line():
    wave = np.exp(2j * np.pi * np.arange(8) / 8)[None]
    assert mpc(wave)[0] == pytest.approx(0, abs=1e-12)
    # Amplitudes all one, angles spread evenly: the mean deviation is pi / 4.
    assert mpd(wave)[0] == pytest.approx(np.pi / 4)


def test_the_mean_phase_deviation_is_that_of_the_points():
    shape = np.array([[1.0, -1.0, 1.0, -1.0]]) * np.exp(1j * np.array([0.1, -0.1, 0.1, -0.1]))
    assert mpd(shape)[0] == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("criterion", [lambda s: mac(s, s), lambda s: comac(s, s), mpc, mpd])
@pytest.mark.parametrize("bad", [REAL[0], REAL * np.nan, REAL * np.array([[1], [0], [1]])], ids=["flat", "nan", "zero"])
def test_what_is_no_set_of_shapes_is_rejected(criterion, bad):
    with pytest.raises(DataError):
        criterion(bad)


def test_shapes_over_other_points_are_rejected():
    for criterion in (mac, comac):
        with pytest.raises(DataError, match=r"points|paired"):
            criterion(REAL, REAL[:, :5])
