"""Responses are those of the equations of motion, at every sample, from rest or from given initial values."""

import numpy as np
import pytest
from chain import BARE
from scipy import signal

from modallab.core.documents.model_use import ForceKind, SineForce, SweepForce
from modallab.core.errors import DataError
from modallab.core.model import ScaleUncertainty
from modallab.core.units import Quantity
from modallab.modification.known import KnownStructure
from modallab.modification.motion import MotionOverTime, force_samples

DT = 1 / 512
N = 2048
KNOWN = KnownStructure(BARE.model(driven=(1, 3)))
INVERSE = np.linalg.inv(BARE.mass)
STATE = np.block([[np.zeros((4, 4)), np.eye(4)], [-INVERSE @ BARE.stiffness, -INVERSE @ BARE.damping]])


def simulated(force: np.ndarray, drive: list[int], quantity: Quantity, start: np.ndarray | None = None) -> np.ndarray:
    """(4, samples) of the state equations, for a force that runs straight from sample to sample."""
    b = np.concatenate([np.zeros((4, len(drive))), INVERSE[:, [p - 1 for p in drive]]])
    rows = {
        "displacement": (np.eye(8)[:4], np.zeros((4, len(drive)))),
        "velocity": (np.eye(8)[4:], np.zeros((4, len(drive)))),
        "acceleration": (STATE[4:], b[4:]),
    }
    c, d = rows[quantity]
    _, y, _ = signal.lsim((STATE, b, c, d), force.T, DT * np.arange(force.shape[1]), start)
    return y.T


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_a_force_that_runs_straight_between_samples_is_exact(quantity: Quantity) -> None:
    force = np.random.default_rng(3).standard_normal((2, N))
    found = KNOWN.response(force, DT, [1, 3], [1, 2, 3, 4], quantity, "linear")
    expected = simulated(force, [1, 3], quantity)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_a_structure_let_go_swings_as_its_equations_say() -> None:
    start = {"displacement": {1: 1e-3, 2: 0.0, 3: -2e-3, 4: 0.0}, "velocity": {1: 0.0, 2: 0.1, 3: 0.0, 4: 0.0}}
    state = np.array([1e-3, 0, -2e-3, 0, 0, 0.1, 0, 0])
    expected = simulated(np.zeros((1, N)), [1], "velocity", state)
    for between in ("linear", "band-limited"):
        found = KNOWN.response(np.zeros((1, N)), DT, [1], [1, 2, 3, 4], "velocity", between, start)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def test_a_band_limited_force_is_exact_between_the_samples_of_a_coarse_rate() -> None:
    """A burst of few lines, 64 times finer for the equations of motion than for the model."""
    fine = 64
    t = DT / fine * np.arange(N * fine)
    burst = np.exp(-(((t - 1.0) / 0.12) ** 2)) * np.sin(2 * np.pi * 60 * t)
    b = np.concatenate([np.zeros((4, 1)), INVERSE[:, :1]])
    _, expected, _ = signal.lsim((STATE, b, STATE[4:], b[4:]), burst, t)
    found = KNOWN.response(burst[None, ::fine], DT, [1], [1, 2, 3, 4])
    coarse = expected[::fine].T
    np.testing.assert_allclose(found, coarse, rtol=0, atol=1e-4 * np.abs(coarse).max())
    straight = KNOWN.response(burst[None, ::fine], DT, [1], [1, 2, 3, 4], between="linear")
    assert np.linalg.norm(straight - coarse) > 50 * np.linalg.norm(found - coarse)


@pytest.mark.parametrize(
    "force",
    [SineForce(frequency_hz=256, amplitude_n=1), SweepForce(from_hz=300, to_hz=3, amplitude_n=1)],
    ids=["sine", "sweep"],
)
def test_steps_that_cannot_hold_a_sine_are_rejected(force: ForceKind) -> None:
    """Its samples would be those of a slower one."""
    with pytest.raises(DataError, match="hold no sine"):
        force_samples(force, DT, N)


def test_what_of_a_force_is_outside_the_band_is_stated() -> None:
    high, t = KNOWN.model.band_hz[1], DT * np.arange(N)
    inside, outside = (np.sin(2 * np.pi * round(hz * N * DT) / (N * DT) * t) for hz in (high / 2, 2 * high))
    found = MotionOverTime.of(KNOWN, inside + 0.5 * outside, DT, [1], [3])
    assert found.outside == pytest.approx(0.25 / 1.25)


def test_with_a_mass_the_response_is_that_of_the_heavier_structure() -> None:
    from modallab.modification.attachments import Element

    t = DT * np.arange(N)
    force = (np.exp(-(((t - 1.0) / 0.12) ** 2)) * np.sin(2 * np.pi * 20 * t))[None]
    heavy = KNOWN.with_changes([Element(3, mass=0.4)])
    mass = BARE.mass.copy()
    mass[2, 2] += 0.4
    inverse = np.linalg.inv(mass)
    state = np.block([[np.zeros((4, 4)), np.eye(4)], [-inverse @ BARE.stiffness, -inverse @ BARE.damping]])
    b = np.concatenate([np.zeros((4, 1)), inverse[:, :1]])
    up = signal.resample(force[0], 16 * N)
    _, expected, _ = signal.lsim((state, b, state[4:], b[4:]), up, DT / 16 * np.arange(16 * N))
    found = heavy.response(force, DT, [1], [1, 2, 3, 4])
    np.testing.assert_allclose(found, expected[::16].T, rtol=0, atol=2e-3 * np.abs(expected).max())


def test_the_deviation_of_a_response_is_that_of_what_is_uncertain() -> None:
    """A frequency known to a share moves the response as the frequency itself does, with a mass or without."""
    from modallab.modification.attachments import Element

    t = DT * np.arange(N)
    force = (np.exp(-(((t - 1.0) / 0.12) ** 2)) * np.sin(2 * np.pi * 20 * t))[None]
    share, exact = 1e-5, ("frequency_sigma_hz", "damping_sigma", "modal_constant_sigma", "residuals")
    model = BARE.model(driven=(1, 3))
    nothing = np.zeros(4)
    known_scale = ScaleUncertainty(
        force=0.0, responses=nothing, modal_constants=nothing, shapes=nothing, modal_mass=0.0
    )
    model = model.model_copy(
        update={name: 0 * getattr(model, name) for name in exact} | {"scale_uncertainty": known_scale}
    )
    unsure = model.model_copy(update={"frequency_sigma_hz": share * model.frequency_hz * np.eye(4)[1]})
    for changes in ([], [Element(3, mass=0.4)]):

        def moved(known: KnownStructure) -> np.ndarray:
            return known.response(force, DT, [1], [1, 2, 3, 4])

        higher, lower = (
            KnownStructure(
                model.model_copy(update={"frequency_hz": model.frequency_hz * (1 + side * share * np.eye(4)[1])})
            )
            for side in (1, -1)
        )
        slope = (moved(higher.with_changes(changes)) - moved(lower.with_changes(changes))) / 2
        sigma = KnownStructure(unsure).with_changes(changes).standard_deviation(moved)
        np.testing.assert_allclose(sigma, np.abs(slope), rtol=0, atol=0.3 * np.abs(slope).max())
        assert np.linalg.norm(sigma) == pytest.approx(np.linalg.norm(slope), rel=0.25)
