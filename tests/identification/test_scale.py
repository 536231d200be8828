"""The sensitivities' uncertainty in a model's scale, against sensitivities that are off by what they may be."""

from datetime import date

import numpy as np
import pytest

from modallab.core.hardware import Calibration, Certificate
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.model.modal_mass import driving_points, relative_sigma, unit_mass_shapes, with_scale
from modallab.modification.deflection import shapes_at_freedoms
from modallab.reporting.figures.mode_shapes import beam_shape
from modallab.reporting.figures.wireframe import shapes_of_model

POINTS = (1, 2, 3)
PHI = np.array([[0.4, 0.9, 1.5]])
DRIVEN = 2


def rig(percent: dict[int, float]) -> Rig:
    kinds = [("force", "N"), *(("acceleration", "m/s^2"),) * 3]
    channels = [
        {"index": n, "name": f"c{n}", "quantity": q, "unit": u, "serial": str(n), "point": n or None}
        | (
            {"certificate": Certificate(serial=str(n), date=date(2025, 1, 1), uncertainty_percent=percent[n])}
            if n in percent
            else {}
        )
        for n, (q, u) in enumerate(kinds)
    ]
    points = [{"id": p, "x_m": 0.1 * p} for p in POINTS]
    return Rig.model_validate({"name": "three sensors", "model": "unknown", "points": points, "channels": channels})


def model(force: float = 1.0, responses: np.ndarray | None = None) -> ModalModel:
    """As read with sensitivities that are wrong by these factors."""
    gains = (np.ones(3) if responses is None else responses) / force
    constants = (PHI[:, :, None] * PHI[:, None, [DRIVEN - 1]] * gains[None, :, None]).astype(complex)
    sigma = np.full(constants.shape, 1e-6)
    shapes = unit_mass_shapes(constants, sigma, POINTS, (DRIVEN,))
    return ModalModel(
        method="rational", band_hz=(1.0, 10.0), frequency_hz=np.array([5.0]), damping_ratio=np.array([0.01]),
        frequency_sigma_hz=np.array([0.0]), damping_sigma=np.array([0.0]), outputs=("c1", "c2", "c3"),
        output_points=POINTS, input_points=(DRIVEN,), modal_constants=constants, modal_constant_sigma=sigma,
        residuals=np.zeros((0, 3, 1)), shapes=shapes.phi, shape_sigma=shapes.sigma, half_power=np.array([np.nan]),
        half_power_floor=np.array([np.nan]),
    )  # fmt: skip


def test_the_stated_scale_is_that_of_sensitivities_drawn_within_it():
    scale = with_scale(model(), rig({0: 2.0, 1: 1.0, 2: 3.0, 3: 4.0})).scale_uncertainty
    assert scale is not None
    rng = np.random.default_rng(1)
    draws = rng.standard_normal((2000, 4)) * np.array([0.01, 0.005, 0.015, 0.02])
    drawn = [model(1 + draw[0], 1 + draw[1:]) for draw in draws]
    constants = np.array([m.modal_constants[0, :, 0].real for m in drawn])
    shapes = np.array([np.abs(m.shapes[0]) for m in drawn if m.shapes is not None])
    assert np.allclose(constants.std(axis=0) / constants.mean(axis=0), scale.modal_constants, rtol=0.08)
    assert np.allclose(shapes.std(axis=0) / shapes.mean(axis=0), scale.shapes, rtol=0.08)
    mass = 1 / shapes[:, DRIVEN - 1] ** 2
    assert mass.std() / mass.mean() == pytest.approx(scale.modal_mass, rel=0.08)


def test_the_statistical_sigmas_stay_as_they_were():
    plain = model()
    assert np.array_equal(with_scale(plain, rig({0: 2.0})).modal_constant_sigma, plain.modal_constant_sigma)


def test_what_no_certificate_states_is_unknown_and_not_nought():
    bare = with_scale(model(), rig({}))
    assert bare.scale_uncertainty is None
    assert "scale_uncertainty" not in bare.model_dump_json()
    half = with_scale(model(), rig({0: 2.0, 2: 1.0})).scale_uncertainty
    assert half is not None
    assert np.isfinite(half.modal_constants).tolist() == [False, True, False]
    again = ModalModel.model_validate_json(with_scale(model(), rig({0: 2.0, 2: 1.0})).model_dump_json())
    assert again.scale_uncertainty is not None
    assert np.isnan(again.scale_uncertainty.responses[0])


def test_the_later_calibration_counts():
    known = rig({1: 2.0})
    own = Calibration(
        date=date(2025, 6, 1), channel="c1", method="reference", sensitivity_v_per_unit=2.0, sigma_v_per_unit=0.06
    )
    channel = known.channels[1]
    assert relative_sigma(channel, known) == 0.01
    assert relative_sigma(channel, known.model_copy(update={"history": (own,)})) == 0.03
    before = own.model_copy(update={"date": date(2024, 1, 1)})
    assert relative_sigma(channel, known.model_copy(update={"history": (before,)})) == 0.01


def test_a_sensor_across_the_drive_is_none_at_the_driving_point():
    """Two sensors stand at the struck point; the one listed first looks across the drive."""
    turned = rig({}).model_dump(mode="json")
    turned["channels"][1] |= {"point": DRIVEN, "direction": "+y"}
    along = Rig.model_validate(turned)
    phi = np.array([[0.2, 0.9, 1.5]])
    constants = (phi[:, :, None] * phi[:, None, [1]]).astype(complex)
    points = tuple(c.point for c in along.responses)
    found = unit_mass_shapes(constants, np.full(constants.shape, 1e-6), points, (DRIVEN,), driving_points(along))
    assert found.phi is not None
    assert np.allclose(np.abs(found.phi), phi, rtol=1e-9)
    across = along.model_copy(update={"drive_direction": "+x"})
    none = unit_mass_shapes(constants, np.full(constants.shape, 1e-6), points, (DRIVEN,), driving_points(across))
    assert "looks along the drive" in none.unavailable


def test_a_hammer_that_roves_past_one_sensor_shows_the_shape_wherever_it_strikes():
    """A_jk = A_kj: one sensor at one of the driven points gives modal mass and shape at all of them."""
    one = rig({}).model_copy(update={"channels": rig({}).channels[:3:2]})
    constants = (PHI[:, [DRIVEN - 1], None] * PHI[:, None, :]).astype(complex)
    sigma = np.full(constants.shape, 1e-6)
    shapes = unit_mass_shapes(constants, sigma, (DRIVEN,), POINTS)
    assert shapes.phi is not None
    roved = model().model_copy(
        update={
            "outputs": ("c2",), "output_points": (DRIVEN,), "input_points": POINTS, "modal_constants": constants,
            "modal_constant_sigma": sigma, "shapes": shapes.phi, "shape_sigma": shapes.sigma,
        }
    )  # fmt: skip
    found = shapes_at_freedoms(roved, one)
    assert found is not None
    freedoms, phi, off = found
    order = np.argsort([point for point, _ in freedoms])
    assert np.allclose(np.abs(phi[:, order]), PHI, rtol=1e-9)
    assert np.all(off > 0)
    drawn = beam_shape(roved, 0, one)
    assert drawn is not None
    assert np.allclose(np.abs(drawn.phi), PHI[0], rtol=1e-9)
    assert np.count_nonzero(shapes_of_model(roved, one)[0].motion) == len(POINTS)
