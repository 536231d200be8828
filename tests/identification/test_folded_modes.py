"""Modes above a band as powers of s, beside the modes themselves."""

import numpy as np
import pytest

from modallab.identification.model.modal_model import POWERS, fold_into_residuals


@pytest.mark.parametrize(("above", "off"), [(1.0, 0.05), (1.05, 0.005), (1.2, 1e-4)])
def test_a_mode_above_the_band_is_met_at_its_lowest_lines_too(above: float, off: float) -> None:
    """A joint's own receptance at low frequencies is made of such modes: there they count as much as near the edge."""
    omega = 2 * np.pi * 100 * above
    poles = np.array([omega * (-0.004 + 1j * np.sqrt(1 - 0.004**2))])
    terms = fold_into_residuals(poles, np.ones((1, 1, 1)), (3.0, 100.0))[:, 0, 0]
    s = 2j * np.pi * np.linspace(3, 75, 300)
    mode = 1 / (s**2 - 2 * poles.real * s + np.abs(poles) ** 2)
    stands = sum(term * s**power for term, power in zip(terms, POWERS, strict=True))
    np.testing.assert_allclose(np.abs(stands / mode - 1), 0, atol=off)
