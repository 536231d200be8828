"""A structure against itself, and a mass on it, whatever phase its measuring chain turns everything by."""

import numpy as np
import pytest
from phased_line import PSI, ZETA, model, rig, with_mass

from modallab.core.model import ModalModel
from modallab.gap.modal.diagnosis import diagnose_by_model

PHASES = (0.0, 3.0, 6.0, 10.0, 20.0, 32.0, 45.0)


def _nothing(of: ModalModel) -> None:
    found = diagnose_by_model(of, of, rig())
    assert (found.verdict, found.effects) == ("no_gap", [])
    assert max(found.nominal, found.before, found.after, found.strain_before) < 1e-9


@pytest.mark.parametrize("degrees", PHASES)
def test_a_model_is_itself_at_every_phase(degrees: float) -> None:
    _nothing(model(degrees=degrees))


@pytest.mark.parametrize("factor", [0.01, 0.2, 1.0, 3.0])
def test_a_model_is_itself_at_every_damping(factor: float) -> None:
    _nothing(model(zeta=factor * ZETA, degrees=15.0))


@pytest.mark.parametrize("seed", range(4))
def test_complex_shapes_are_themselves(seed: int) -> None:
    """Every shape at every point turned by itself, also so far that a driving point is none of a passive structure."""
    twist = np.random.default_rng(seed).normal(0.0, 0.5 * (seed + 1), PSI.shape)
    _nothing(model(twist=twist, driven=(1, 3)))


def test_constants_that_are_no_product_are_themselves() -> None:
    of = model(driven=(1, 2, 3), degrees=8.0)
    noise = np.random.default_rng(2).standard_normal((2, *of.modal_constants.shape)) * 0.02
    _nothing(of.model_copy(update={"modal_constants": of.modal_constants + noise[0] + 1j * noise[1]}))


def test_one_sensor_at_one_driven_point_is_itself() -> None:
    _nothing(model(sensors=(1,)))


def test_without_a_driving_point_it_is_itself() -> None:
    _nothing(model(sensors=(2, 3)))


@pytest.mark.parametrize("degrees", PHASES)
def test_a_mass_is_named_at_every_phase(degrees: float) -> None:
    found = diagnose_by_model(model(degrees=degrees), with_mass(1.0, 3, degrees), rig())
    (effect,) = found.effects
    assert effect.effect == "added_mass"
    assert effect.parameters["mass"] == pytest.approx(1.0, rel=0.1)
