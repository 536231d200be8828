"""The truth is a chain of three masses in closed form, with and without a mass at the driven one."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.frf.estimate import convert_frf
from modallab.frf.mass_cancellation import without_mass

F = np.linspace(1.0, 40.0, 400)
MASS = np.diag([1.0, 0.8, 0.5])
STIFFNESS = 4e3 * np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
EXTRA = 0.07


def frf(points=(3,), extra=0.0, quantity="inertance"):
    """What a transducer behind `extra` kg measures when it drives each point by itself."""
    s = 2j * np.pi * F
    values = []
    for point in points:
        loaded = MASS + np.diag([extra if p == point else 0.0 for p in (1, 2, 3)])
        dynamic = STIFFNESS * (1 + 0.004j) + loaded * s[:, None, None] ** 2
        values.append(np.linalg.inv(dynamic)[:, :, point - 1].T)
    receptance = Frf(F, np.stack(values, axis=1), "receptance", ("a", "b", "c"), (1, 2, 3), points)
    return convert_frf(receptance, quantity)


@pytest.mark.parametrize("quantity", ["receptance", "mobility", "inertance"])
def test_the_mass_between_transducer_and_structure_is_gone(quantity):
    loaded, free = frf((3, 1), EXTRA, quantity), frf((3, 1), 0.0, quantity)
    assert np.abs(loaded.values / free.values - 1).max() > 1
    np.testing.assert_allclose(without_mass(loaded, (EXTRA, EXTRA)).values, free.values, rtol=1e-9)


def test_an_input_without_a_mass_stays_as_it_is():
    loaded = frf((3, 1), EXTRA)
    cleared = without_mass(loaded, (EXTRA, 0.0))
    np.testing.assert_array_equal(cleared.values[:, 1], loaded.values[:, 1])
    np.testing.assert_allclose(cleared.values[:, 0], frf((3,)).values[:, 0], rtol=1e-9)


def test_the_variance_grows_where_the_mass_took_most_of_the_force():
    loaded = replace(frf((3,), EXTRA), variance=np.ones((3, 1, F.size)))
    factor = np.abs(frf((3,)).values[0, 0] / loaded.values[0, 0]) ** 2
    np.testing.assert_allclose(without_mass(loaded, (EXTRA,)).variance[0, 0], factor, rtol=1e-9)


@pytest.mark.parametrize("mass", [(np.nan,), (-0.1,), (np.inf,), (), (0.1, 0.1)], ids=str)
def test_masses_that_are_none_are_rejected(mass):
    with pytest.raises(DataError, match="masses"):
        without_mass(frf((3,)), mass)


def test_without_a_sensor_at_the_driven_point_nobody_knows_what_the_mass_took():
    unseen = replace(frf((3,)), output_points=(1, 2, None))
    unknown = replace(frf((3,)), input_points=(None,))
    for bad in (unseen, unknown):
        with pytest.raises(DataError, match="driven point"):
            without_mass(bad, (0.1,))


@pytest.mark.parametrize("spoil", [np.nan, np.inf])
def test_frfs_that_are_none_are_rejected(spoil):
    with pytest.raises(DataError):
        without_mass(replace(frf((3,)), values=frf((3,)).values * spoil), (0.1,))
