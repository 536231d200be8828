"""Periods recorded long before a mode has settled: the decays are taken off, and what is left is the steady state."""

import numpy as np
import pytest
from scipy.signal import lfilter

from modallab.core.block import Block
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.frf.periodic_drive import without_decays
from modallab.identification.options import IdentificationOptions
from modallab.identification.parts import with_repeatability_sigmas
from modallab.pipelines.averaged_frfs import frf_of_drive, identify_drive
from modallab.signals.signals import Signals

RATE_HZ, N, BLOCKS = 256.0, 256, 12
F_HZ, ZETA = np.array([5.0, 31.0]), np.array([0.006, 0.004])
POLES = 2 * np.pi * F_HZ * (-ZETA + 1j * np.sqrt(1 - ZETA**2))


def respond(force: np.ndarray) -> np.ndarray:
    """(2, samples) from rest; the same recursion in the steady state, so that no other error is in it."""
    rows = np.zeros((2, force.size))
    for pole, phi in zip(POLES, ((1.0, 0.5), (0.3, -1.0)), strict=True):
        z = np.exp(pole / RATE_HZ)
        state = lfilter([1.0], [1.0, -z], force)
        rows += np.outer(phi, np.imag(state))
    return rows


def records(noise: float = 0.0) -> tuple[list[Signals], np.ndarray]:
    """Blocks from the start on, and the settled response."""
    rng = np.random.default_rng(1)
    spectrum = np.zeros(N // 2 + 1, complex)
    spectrum[2:100] = np.exp(2j * np.pi * rng.uniform(size=98))
    period = 10 * np.fft.irfft(spectrum, N)
    force = np.tile(period, BLOCKS)
    rows = respond(force)
    settled = respond(np.tile(period, 400))[:, -N:]
    found = []
    for k in range(BLOCKS):
        here = slice(k * N, (k + 1) * N)
        block = Block(
            name=f"b{k}", test="pseudo-random", order=k, rate_hz=RATE_HZ, samples=np.zeros((3, N)), scale=np.ones(3),
            units=("N", "m/s^2", "m/s^2"), channels=("force", "a", "b"), first_sample=k * N,
        )  # fmt: skip
        values = rows[:, here] + noise * rng.standard_normal((2, N))
        found.append(Signals(forces=force[here], responses=values, rate_hz=RATE_HZ, outputs=("a", "b"), block=block))
    return found, settled


@pytest.mark.parametrize(("off", "left"), [(0.0, 1e-9), (1e-3, 0.1)])
def test_what_is_left_is_the_steady_state(off: float, left: float) -> None:
    signals, settled = records()
    before = max(np.abs(s.responses - settled).max() for s in signals[:3]) / np.abs(settled).max()
    clean = without_decays(signals, POLES * (1 + off), (2.0, 90.0))
    after = max(np.abs(s.responses - settled).max() for s in clean[:3]) / np.abs(settled).max()
    assert before > 0.3
    assert after < left * before + 1e-9
    np.testing.assert_allclose([s.force for s in clean], [s.force for s in signals], atol=1e-9)


def test_the_decays_are_taken_off_until_the_poles_stand_still() -> None:
    signals, _ = records(1e-3)
    late = [s for s in signals if s.block.order in (2, 3, 4)]
    channels = (("force", "force", "N"), ("a", "acceleration", "m/s^2"), ("b", "acceleration", "m/s^2"))
    rig = Rig(
        name="two modes", model="unknown", points=(Point(id=1, x_m=0.0), Point(id=2, x_m=1.0)),
        channels=tuple(
            Channel(index=k, name=name, quantity=quantity, unit=unit, point=max(1, k))  # pyright: ignore[reportArgumentType]
            for k, (name, quantity, unit) in enumerate(channels)
        ),
    )  # fmt: skip
    model, _, _ = identify_drive(late, frf_of_drive(late, rig, (2.0, 90.0)), rig, IdentificationOptions())
    np.testing.assert_allclose(model.frequency_hz, F_HZ, rtol=2e-4)
    np.testing.assert_allclose(model.damping_ratio, ZETA, rtol=0.03)


def test_one_block_alone_stays_as_it_is() -> None:
    signals, _ = records()
    assert without_decays(signals[:1], POLES, (2.0, 90.0)) == signals[:1]


def test_parts_that_differ_make_the_sigma_larger() -> None:
    s = 2j * np.pi * np.arange(1.0, 61.0, 0.25)

    def part(shift: float) -> Frf:
        w, zeta = 2 * np.pi * 20 * (1 + shift), 0.02
        values = s**2 / (s**2 + 2 * zeta * w * s + w**2)
        return Frf(s.imag / (2 * np.pi), values[None, None], "inertance", ("a",), (1,), (1,))

    n = np.full(1, 1e-6)
    model = ModalModel(
        method="plscf", band_hz=(1, 60), frequency_hz=np.array([20.0]), damping_ratio=np.array([0.02]),
        frequency_sigma_hz=n, damping_sigma=n, outputs=("a",), output_points=(1,), input_points=(1,),
        modal_constants=np.ones((1, 1, 1)), modal_constant_sigma=np.ones((1, 1, 1)), residuals=np.zeros((0, 1, 1)),
        half_power=n, half_power_floor=n,
    )  # fmt: skip
    shifts = np.array([1e-4, -2e-4, 3e-4, 0.0])
    wider = with_repeatability_sigmas(model, [part(x) for x in shifts])
    expected = 20 * np.std(shifts, ddof=1) / 2 * 1.624
    assert wider.frequency_sigma_hz[0] == pytest.approx(expected, rel=0.02)
    assert wider.damping_sigma[0] == pytest.approx(1e-6, rel=0.1)
    assert with_repeatability_sigmas(model, []) is model
