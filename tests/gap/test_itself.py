"""A structure against itself, and a mass on it, whatever phase its measuring chain turns everything by."""

import numpy as np
import pytest
from phased_line import OMEGA, PSI, ZETA, model, rig, with_mass

from modallab.blind.measured.draw import AppliedEffect
from modallab.blind.measured.score import Truth, judge_trial
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.gap.modal.diagnosis import diagnose_by_model

AGAIN = pytest.mark.thorough("diagnoses a structure once more")
PHASES = [p if p == 45.0 else pytest.param(p, marks=AGAIN) for p in (0.0, 3, 10.0, 20, 45.0)]


def _nothing(of: ModalModel) -> None:
    found = diagnose_by_model(of, of, rig())
    assert (found.verdict, found.effects) == ("no_gap", [])
    assert max(found.nominal, found.before, found.after, found.strain_before) < 1e-9


@pytest.mark.parametrize("degrees", PHASES)
def test_a_model_is_itself_at_every_phase(degrees: float) -> None:
    _nothing(model(degrees=degrees))


@pytest.mark.parametrize("factor", [pytest.param(0.01, marks=AGAIN), 3.0])
def test_a_model_is_itself_at_every_damping(factor: float) -> None:
    _nothing(model(zeta=factor * ZETA, degrees=15.0))


@pytest.mark.parametrize("seed", [pytest.param(0, marks=AGAIN), 3])
def test_complex_shapes_are_themselves(seed: int) -> None:
    """Every shape at every point turned by itself, also so far that a driving point is none of a passive structure."""
    twist = np.random.default_rng(seed).normal(0.0, 0.5 * (seed + 1), PSI.shape)
    _nothing(model(twist=twist, driven=(1, 3)))


@pytest.mark.thorough("diagnoses a structure once more")
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


@pytest.mark.thorough("diagnoses a structure once more")
def test_a_late_trigger_is_named_with_its_time() -> None:
    late = model(degrees=12.0)
    turned = np.exp(-2j * np.pi * late.frequency_hz * 4e-4)[:, None, None]
    bench = late.model_copy(update={"modal_constants": late.modal_constants * turned})
    (effect,) = diagnose_by_model(model(degrees=12.0), bench, rig()).effects
    assert effect.effect == "trigger_delay"
    assert effect.parameters["seconds"] == pytest.approx(4e-4, rel=0.02)


def test_a_damper_is_named() -> None:
    """By the poles of the state matrix, with shapes that the damper makes complex."""
    c, n = 60.0, OMEGA.size
    damping = np.diag(2 * ZETA * OMEGA) + c * np.outer(PSI[:, 0], PSI[:, 0])
    poles, vectors = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(OMEGA**2), -damping]]))
    chosen = np.argsort(poles.imag)[n:]
    poles, vectors = poles[chosen], vectors[:n, chosen]
    # Normed so that an FRF is the sum of v v^T / (s - pole) and its conjugate.
    scale = np.array([v @ (2 * p * np.eye(n) + damping) @ v for p, v in zip(poles, vectors.T, strict=True)])
    shapes = (vectors * np.sqrt(2j * poles.imag / scale)).T @ PSI
    found = diagnose_by_model(model(), model(shapes, np.abs(poles), zeta=-poles.real / np.abs(poles)), rig())
    (effect,) = found.effects
    assert (effect.effect, effect.place.point) == ("local_damper", 1)
    assert effect.parameters["c"] == pytest.approx(c, rel=0.2)


def test_one_sensor_at_one_driven_point_shows_a_mass_there() -> None:
    (effect,) = diagnose_by_model(model(sensors=(1,)), with_mass(0.3, 1, sensors=(1,)), rig()).effects
    assert effect.effect == "added_mass"
    assert effect.parameters["mass"] == pytest.approx(0.3, rel=0.1)


def test_with_one_sensor_a_wrong_gain_may_be_the_force_channel_s() -> None:
    """Both are exact: the diagnosis says so, and a trial counts the true one as not ruled out."""
    of = model(sensors=(1,))
    found = diagnose_by_model(of, of.model_copy(update={"modal_constants": 1.3 * of.modal_constants}), rig())
    assert found.explanations().keys() == {"gain_error", "force_gain"}
    assert found.explanations()["gain_error"] == pytest.approx(found.explanations()["force_gain"], rel=0.05)
    assert any("do not distinguish" in note for note in found.notes)
    assert judge_trial("", Truth(AppliedEffect("gain_error", 1.3, output=0), "a1"), found).among
    assert not judge_trial("", Truth(AppliedEffect("added_mass", 1.0, output=0, input=0), "1"), found).among


@pytest.mark.thorough("diagnoses a structure once more")
def test_a_bench_driven_elsewhere_is_compared_by_reciprocity() -> None:
    assert diagnose_by_model(model(), model(driven=(2,)), rig()).verdict == "no_gap"


@AGAIN
def test_a_mass_is_found_by_a_bench_driven_elsewhere() -> None:
    (effect,) = diagnose_by_model(model(), with_mass(1.0, 3, driven=(2,)), rig()).effects
    assert effect.effect == "added_mass"
    assert effect.parameters["mass"] == pytest.approx(1.0, rel=0.1)


def test_without_a_scale_nothing_is_driven_elsewhere() -> None:
    with pytest.raises(DataError, match="share no output or no driven point"):
        diagnose_by_model(model(sensors=(2, 3)), model(sensors=(2, 3), driven=(2,)), rig())
