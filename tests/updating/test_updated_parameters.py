"""Parameters of a model estimated from modes: closed forms, and what the data cannot say."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.formats.fem.matrix_model import MatrixModel
from modallab.updating.posterior import update_parameters
from modallab.updating.result import ModeData, Prior

N = 6


def chain() -> MatrixModel:
    """Masses of 1 kg between springs of 1e5 N/m, the first to ground."""
    k = 1e5 * (2 * np.eye(N) - np.eye(N, k=1) - np.eye(N, k=-1))
    k[-1, -1] = 1e5
    tip, first = np.zeros((N, N)), np.zeros((N, N))
    tip[-1, -1] = first[0, 0] = 1.0
    rows = [(n, "z") for n in range(1, N + 1)]
    return MatrixModel(k, np.eye(N), rows, {"ground spring": tip}, {"tip mass": tip, "first mass": first})


CHAIN = chain()


def predict(numbers: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    modes = CHAIN.modes(numbers)
    return modes.frequency_hz, np.stack([modes.at[n][:, 2] for n in range(1, N + 1)], axis=1)


def measured(hz_sigma: float = 1e-4, shape_sigma: float = 0.01, **numbers: float) -> ModeData:
    hz, shapes = predict(numbers)
    sigma = np.repeat([hz_sigma, shape_sigma], (hz.size, shapes.size))
    return ModeData(hz, hz_sigma * hz, shapes, np.diag(sigma**2))


PRIORS = {
    "stiffness": Prior(1.0, 0.05, True),
    "ground spring": Prior(0.0, 3e3),
    "tip mass": Prior(0.0, 0.2),
}


def test_a_stiffness_that_is_wrong_as_a_whole_is_no_local_spring() -> None:
    found = update_parameters(predict, PRIORS, measured(stiffness=0.97))
    assert found.numbers["stiffness"] == pytest.approx(0.97, abs=2e-3)
    assert abs(found.numbers["ground spring"]) < 100
    low, high = found.interval["ground spring"]
    assert low < 0 < high
    assert found.undetermined_parameters == ()


def test_modes_held_out_come_nearer_though_the_estimate_does_not_see_them() -> None:
    data = measured(**{"tip mass": 0.15, "ground spring": 3e3})
    found = update_parameters(predict, PRIORS, data, held_out=(2, 5))
    before, after = found.rms_error((2, 5))
    assert after < before / 10
    hz = data.frequency_hz.copy()
    hz[1] *= 1.2
    unseen = update_parameters(predict, PRIORS, replace(data, frequency_hz=hz), held_out=(2, 5))
    assert unseen.numbers == found.numbers


def test_stiffness_and_mass_alone_are_not_determined_by_shapes_without_a_scale() -> None:
    priors = {"stiffness": Prior(1.0, 0.02, True), "mass": Prior(1.0, 0.02, True)}
    found = update_parameters(predict, priors, measured(1e-4, 10.0, stiffness=1.01))
    assert found.correlated_pairs == (("mass", "stiffness"),)
    assert set(found.undetermined_parameters) == {"stiffness", "mass"}
    both = found.numbers["stiffness"] / found.numbers["mass"]
    assert both == pytest.approx(1.01, abs=1e-3)


def test_what_moves_nothing_keeps_its_prior_and_is_named() -> None:
    priors = PRIORS | {"paint": Prior(3.0, 1.0)}
    found = update_parameters(
        lambda p: predict({n: v for n, v in p.items() if n != "paint"}), priors, measured(stiffness=1.02)
    )
    assert found.undetermined_parameters == ("paint",)
    assert found.interval["paint"] == pytest.approx((3 - 1.96, 3 + 1.96), abs=0.15)


def test_intervals_hold_the_truth_about_as_often_as_they_say() -> None:
    rng, inside = np.random.default_rng(5), []
    for _ in range(5):
        true = {n: float(p.at(rng.standard_normal())) for n, p in PRIORS.items()}
        data = measured(**true)
        noise = rng.standard_normal(len(data.covariance)) * np.sqrt(np.diag(data.covariance))
        shapes = data.shapes + data.size * noise[N:].reshape(N, N)
        noisy = replace(data, frequency_hz=data.frequency_hz * np.exp(noise[:N]), shapes=shapes)
        found = update_parameters(predict, PRIORS, noisy)
        inside += [low <= true[n] <= high for n, (low, high) in found.interval.items()]
    assert sum(inside) >= 13


@pytest.mark.parametrize(
    ("priors", "held_out", "said"),
    [
        ({}, (), "no parameter to estimate"),
        (PRIORS, (9,), "no mode 9 to hold out"),
        (PRIORS, (1, 2, 3, 4, 5), "1 modes remain"),
        ({"colour": Prior(0, 1)}, (), "no parameter 'colour'"),
    ],
)
def test_what_cannot_be_estimated_is_said(priors: dict[str, Prior], held_out: tuple[int, ...], said: str) -> None:
    with pytest.raises(DataError, match=said):
        update_parameters(predict, priors, measured(), held_out)


def test_a_model_with_too_few_modes_says_so() -> None:
    def short(numbers: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        hz, shapes = predict(numbers)
        return hz[:3], shapes[:3]

    with pytest.raises(DataError, match="has 3 modes, and 6 were measured"):
        update_parameters(short, PRIORS, measured())


@pytest.mark.parametrize("wrong", [Prior, lambda v, s: Prior(v, s, True)])
def test_a_prior_without_a_deviation_is_rejected(wrong: type[Prior]) -> None:
    with pytest.raises(DataError, match="is none"):
        wrong(1.0, 0.0)


def test_matrices_may_be_lists_and_rows_of_several_lengths_are_none() -> None:
    rows = [(n, "z") for n in (1, 2)]
    assert MatrixModel([[2, -1], [-1, 2]], [[1, 0], [0, 1]], rows).modes({}).frequency_hz.size == 2
    with pytest.raises(DataError, match="the mass matrix is none"):
        MatrixModel([[2, -1], [-1, 2]], [[1, 0], [0]], rows)


def test_matrices_of_another_size_are_rejected() -> None:
    with pytest.raises(DataError, match="tip mass is"):
        replace(CHAIN, mass_slopes={"tip mass": np.eye(3)})
