"""Responses alone in Python and as a job: no force is needed, and the shapes are said to have no scale."""

import numpy as np
import pytest
from scipy.signal import lfilter

import modallab as ml
from modallab.core.errors import DataError, IdentificationError, JobError
from modallab.pipelines.job_kinds import kinds
from modallab.pipelines.parameters import parse_parameters

RATE_HZ, F_HZ, ZETA = 64.0, 9.0, 0.02


def records() -> np.ndarray:
    rng = np.random.default_rng(1)
    omega = 2 * np.pi * F_HZ
    z = np.exp(omega * (-ZETA + 1j * np.sqrt(1 - ZETA**2)) / RATE_HZ)
    one = lfilter([1.0], [1, -2 * z.real, abs(z) ** 2], rng.standard_normal(int(120 * RATE_HZ)))
    return np.outer([1.0, -0.5], one) + 1e-3 * rng.standard_normal((2, one.size))


def test_arrays_without_a_force_are_identified_at_once() -> None:
    model = ml.identify(ml.responses(records(), RATE_HZ, points=[3, 7]), band=(4.0, 25.0))
    assert len(model) == 1
    assert abs(model.modal_model.frequency_hz[0] - F_HZ) < 4 * model.modal_model.frequency_sigma_hz[0]
    assert model.modal_model.output_points == (3, 7)
    np.testing.assert_allclose(model.modal_model.operating_shapes, [[1.0, -0.5]], atol=0.01)
    assert "Shapes are unscaled" in model.modal_model.notes[0]
    with pytest.raises(IdentificationError, match="only the band"):
        ml.identify(ml.responses(records(), RATE_HZ), pick=(9.0,))


@pytest.mark.parametrize(("y", "given"), [(records(), {"points": [1]}), (records(), {"names": ["a", "a"]})])
def test_points_and_names_are_one_for_each_response(y: np.ndarray, given: dict) -> None:
    with pytest.raises(DataError, match="for 2 responses"):
        ml.responses(y, RATE_HZ, **given)


@pytest.mark.parametrize("kind", ["identify", "report"])
def test_a_job_finds_them_too(tmp_path, kind: str) -> None:
    campaign = ml.responses(records(), RATE_HZ).campaign
    job = next(k for k in kinds(lambda _: campaign, tmp_path) if k.name == kind)
    given = {"response_only": True, "response_method": "plscf_spectra", "band_hz": [4.0, 25.0]}
    computed = job.compute(job.load(given, ("run",)), lambda *_: None)
    (model,) = computed.result["models"]
    assert model["method"] == "plscf_spectra"
    assert model["operating_shapes"]["re"][0][0] == 1.0


def test_what_does_not_go_with_the_responses_alone_is_rejected() -> None:
    with pytest.raises(JobError, match="response_only cannot be combined with pick_hz"):
        parse_parameters("identify", {"response_only": True, "pick_hz": [9.0]})
