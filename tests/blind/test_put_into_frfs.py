"""Effects put into measured FRFs, held against the same effects in the equations of motion."""

import numpy as np
import pytest

from modallab.blind.measured.draw import AppliedEffect, with_effect
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity

MASS = np.diag([2.0, 1.0, 1.5])
STIFFNESS = 1e5 * np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
DAMPING = 1e-4 * STIFFNESS + 0.5 * MASS
HZ = np.linspace(1.0, 100.0, 80)


def frf(mass: np.ndarray, damping: np.ndarray, stiffness: np.ndarray, quantity: FrfQuantity) -> Frf:
    s = 2j * np.pi * HZ[:, None, None]
    receptance = np.linalg.inv(s**2 * mass + s * damping + stiffness)[:, :, [0, 1]]
    values = np.moveaxis(receptance * s ** DERIVATIVES[quantity], 0, -1)
    return Frf(HZ, np.asarray(values), quantity, ("a1", "a2", "a3"), (1, 2, 3), (1, 2))


@pytest.mark.parametrize("quantity", ["receptance", "mobility", "inertance"])
@pytest.mark.parametrize(
    ("effect", "value", "matrix"),
    [("added_mass", 0.4, 0), ("local_damper", 30.0, 1), ("ground_spring", 2e4, 2)],
)
def test_what_hangs_there_is_exact(quantity: FrfQuantity, effect: str, value: float, matrix: int) -> None:
    changed = [MASS, DAMPING, STIFFNESS]
    at = np.zeros((3, 3))
    at[1, 1] = value
    changed[matrix] = changed[matrix] + at
    there = with_effect(frf(MASS, DAMPING, STIFFNESS, quantity), AppliedEffect(effect, value, output=1, input=1))
    np.testing.assert_allclose(there.values, frf(*changed, quantity).values, rtol=1e-9)


def test_a_channel_is_changed_alone_and_a_delay_in_all() -> None:
    sound = frf(MASS, DAMPING, STIFFNESS, "inertance")
    gain = with_effect(sound, AppliedEffect("gain_error", 1.2, output=2)).values / sound.values
    np.testing.assert_allclose(gain, np.array([1.0, 1.0, 1.2])[:, None, None] * np.ones(gain.shape))
    late = with_effect(sound, AppliedEffect("trigger_delay", 1e-3)).values / sound.values
    np.testing.assert_allclose(late, np.broadcast_to(np.exp(-2e-3j * np.pi * HZ), late.shape))
    moved = with_effect(sound, AppliedEffect("position_error", output=0, other=1)).values
    np.testing.assert_array_equal(moved[0], sound.values[1])


def test_nothing_done_is_what_was_measured() -> None:
    sound = frf(MASS, DAMPING, STIFFNESS, "mobility")
    assert with_effect(sound, None) is sound
