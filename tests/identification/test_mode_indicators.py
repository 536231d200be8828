import numpy as np
import pytest
from test_plscf import frf

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.estimators.circle import circle_fit
from modallab.identification.start.bands import cmif, mmif

PHI = np.random.default_rng(0).standard_normal((3, 6))
LINES = np.arange(20, 60, 0.02)


def near(hz):
    return int(np.argmin(np.abs(LINES - hz)))


def test_it_dips_at_every_resonance():
    found = mmif(frf([30.0, 40.0, 50.0], [0.005] * 3, PHI, [0], LINES))[0]
    assert np.all((found >= 0) & (found <= 1))
    for hz in (30.0, 40.0, 50.0):
        here = slice(near(hz) - 50, near(hz) + 50)
        assert abs(LINES[here][np.argmin(found[here])] - hz) < 0.1
        assert found[here].min() < 0.3


@pytest.mark.parametrize("quantity", ["mobility", "inertance"])
def test_the_quantity_does_not_matter(quantity):
    case = ([30.0, 40.0, 50.0], [0.005] * 3, PHI, [0, 1], LINES)
    np.testing.assert_allclose(mmif(frf(*case, quantity)), mmif(frf(*case)), atol=1e-9)


def test_two_modes_at_one_frequency_are_two_dips_and_two_singular_values():
    one = frf([40.0, 80.0, 90.0], [0.005] * 3, PHI, [0, 3], LINES)
    two = frf([40.0, 40.0, 90.0], [0.005] * 3, PHI, [0, 3], LINES)
    at = near(40.0)
    assert mmif(one)[:, at][0] < 0.05 < 0.5 < mmif(one)[:, at][1]
    assert mmif(two)[:, at].max() < 0.05
    beside = near(42.0)
    assert cmif(one)[1, at] < 3 * cmif(one)[1, beside]
    assert cmif(two)[1, at] > 30 * cmif(two)[1, beside]
    assert np.all(np.diff(cmif(two), axis=0) <= 0)


def test_without_phase_there_is_no_indicator():
    good = frf([30.0, 40.0, 50.0], [0.005] * 3, PHI, [0], LINES)
    object.__setattr__(good, "values", np.abs(good.values))
    for indicator in (mmif, cmif):
        with pytest.raises(DataError, match="phase"):
            indicator(good)


@pytest.mark.parametrize(("hz", "zeta", "constant"), [(40.0, 0.004, 1.3), (33.3, 0.02, -0.2 + 0.05j)])
def test_a_circle_alone_is_read_exactly(hz, zeta, constant):
    f = np.linspace(hz * (1 - 2 * zeta), hz * (1 + 2 * zeta), 25)
    s, w = 2j * np.pi * f, 2 * np.pi * hz
    found = circle_fit(f, constant * s / (s**2 + 2 * zeta * w * s + w**2) + 0.02 - 0.01j)
    assert found.frequency_hz == pytest.approx(hz, rel=1e-7)
    assert found.damping_ratio == pytest.approx(zeta, rel=1e-5)
    assert found.constant == pytest.approx(constant, rel=1e-4)
    assert found.misfit < 1e-9


def test_noise_has_no_circle():
    rng = np.random.default_rng(1)
    with pytest.raises((IdentificationError, DataError)):
        circle_fit(np.linspace(10, 11, 40), rng.standard_normal(40) + 1j * rng.standard_normal(40))


@pytest.mark.parametrize(
    ("f", "values"),
    [
        (np.linspace(1, 2, 4), np.ones(4) * 1j),
        (np.linspace(2, 1, 9), np.ones(9) * 1j),
        (np.linspace(1, 2, 9), np.full(9, np.nan) * 1j),
        (np.linspace(1, 2, 9), np.ones(9) + 0j),
        (np.linspace(1, 2, 9), np.ones(8) * 1j),
    ],
    ids=["few", "descending", "nan", "magnitude only", "shapes"],
)
def test_what_makes_no_circle_is_rejected(f, values):
    with pytest.raises(DataError):
        circle_fit(f, values)
