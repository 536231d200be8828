from dataclasses import replace

import numpy as np
import pytest
from test_plscf import frf

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.estimators.plscf import plscf
from modallab.identification.selection.diagram import IN_FREQUENCY, NEW, STABLE, stabilisation_diagram
from modallab.identification.start.stabilisation import OrderPoles

PHI = np.random.default_rng(0).standard_normal((3, 6))
LINES = np.arange(20, 60, 0.05)
TRUTH = (30.0, 40.0, 50.0)


def case():
    return frf(TRUTH, [0.005] * 3, PHI, [0, 3], LINES)


def pole(hz, zeta):
    return 2 * np.pi * hz * complex(-zeta, np.sqrt(1 - zeta**2))


def test_true_modes_stand_in_a_column_and_are_the_ones_that_hold():
    it = case()
    found = stabilisation_diagram(it, plscf(it, 14))
    np.testing.assert_allclose(found.held_hz, TRUTH, rtol=1e-6)
    for hz in TRUTH:
        here = np.abs(found.frequency_hz / hz - 1) < 1e-4
        assert np.sum(found.standing[here] == STABLE) >= 10
    assert found.cmif.shape == found.mmif.shape == (2, LINES.size)


def test_a_pole_stands_by_what_the_order_below_had():
    orders = [
        OrderPoles(2, np.array([pole(30, 0.005)])),
        OrderPoles(3, np.array([pole(30.001, 0.0051), pole(40, 0.01)])),
        OrderPoles(4, np.array([pole(30.001, 0.05), pole(40, -0.1), pole(45, 0.3)])),
    ]
    found = stabilisation_diagram(case(), orders)
    assert found.order.tolist() == [2, 3, 3, 4]
    assert found.standing.tolist() == [NEW, STABLE, NEW, IN_FREQUENCY]
    assert found.damping_ratio[-1] == pytest.approx(0.05)


def test_without_orders_or_phase_there_is_no_diagram():
    it = case()
    with pytest.raises(IdentificationError, match="no orders"):
        stabilisation_diagram(it, [])
    with pytest.raises(DataError, match="NaN"):
        stabilisation_diagram(replace(it, values=it.values * np.nan), plscf(it, 4))
