"""What an element adds to the motion of the modes in a record: a hit, or a sine from its start on."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.modes import TwinModes
from modallab.twin.nonlinear.element import ModalCoupling, NonlinearLaw
from modallab.twin.nonlinear.in_band import REACH, FineSteps
from modallab.twin.nonlinear.steps import ModalSteps

PER_PERIOD = 36
"""Steps a period of a sine, where there may be as many."""
HIT_STEPS = 8
"""Steps a sample of a hit."""
LEAST = {NonlinearLaw.CUBIC: 2, NonlinearLaw.DRAG: 1, NonlinearLaw.PLAY: 8, NonlinearLaw.CRACK: 3}
"""Steps a sample of a sine at least: fewer where a law is smooth, more where a stiff contact strikes; 4 otherwise."""
MOST = 8
"""Steps a sample of a sine at most."""


def prepared_steps(modes: TwinModes, own: ModalCoupling, dt: float, x_m: float) -> Callable[[int], ModalSteps]:
    """Steps of a beam and an element, so many a sample of `dt` s, driven at `x_m`: made ready once for many records."""

    @lru_cache(maxsize=MOST)
    def steps(every: int) -> ModalSteps:
        return ModalSteps.of(modes, own, dt / every, x_m)

    return steps


def added_in_hit(steps: Callable[[int], ModalSteps], pulse: Real, first: int, n: int) -> FineSteps:
    """What the element adds to a hit.

    Args:
        steps: of the beam and the element.
        pulse: (m,) force in N about the hit.
        first: sample at which the pulse begins.
        n: samples of the record.
    """
    begin = max(0, first - 32)
    record = np.zeros(n)
    record[first : first + len(pulse)] = pulse[: n - first]
    spectrum = np.fft.rfft(record)
    fine = np.asarray(np.fft.irfft(spectrum, n * HIT_STEPS) * HIT_STEPS, dtype=np.float64)
    still_after = np.zeros(REACH * HIT_STEPS)
    force = np.concatenate([fine[begin * HIT_STEPS :], still_after])
    return FineSteps(steps(HIT_STEPS).run(force, 0), HIT_STEPS, 0, n, begin)


def added_in_sine(
    steps: Callable[[int], ModalSteps],
    law: NonlinearLaw,
    amplitude_n: complex,
    frequency_hz: float,
    n: int,
    dt: float,
    history_s: float,
    ramp_s: float,
    cosine: bool,
    coarse: bool = False,
) -> FineSteps:
    """What it adds to a sine block that began `history_s` before, rising for `ramp_s` from rest.

    Coarse is in half of the steps.
    """
    from modallab.twin.nonlinear.sampling import rising_sine

    every = int(np.clip(np.ceil(PER_PERIOD * frequency_hz * dt), LEAST.get(law, 4), MOST))
    every = -(-every // 2) if coarse else every
    h = dt / every
    skip = round(history_s / h)
    force = np.empty(skip + (n - 1 + REACH) * every + 1)
    # Straight lines between the steps of a sine are that much smaller than the sine.
    larger = complex(amplitude_n / np.sinc(frequency_hz * h) ** 2)
    rising_sine(
        larger, 2 * np.pi * frequency_hz * h, float(skip), history_s / h - skip, max(ramp_s, 1e-6) / h, cosine, force
    )
    # Every step about the record is kept, and what rings above its band taken out as a converter does.
    before = min(skip, REACH * every)
    return FineSteps(steps(every).run(force, skip - before), every, before, n)


def added_acceleration(modes: TwinModes, own: ModalCoupling, psi: Complex, added: FineSteps, dt: float) -> Real:
    """(points, n) m/s^2 that it adds where the modes' shapes are `psi` (points, p)."""
    motion, force = added.sampled()
    p = len(motion)
    straight = 2 * np.real((psi[:, :p] * modes.poles[:p]) @ own.shapes[:, :p].T)
    total = 2 * np.real((psi[:, :p] * modes.poles[:p] ** 2) @ motion) + straight @ force.T
    # What follows at once: its static motion, twice differentiated.
    static = -2 * np.real((psi[:, p:] / modes.poles[p:]) @ own.shapes[:, p:].T)
    second_derivative = np.gradient(np.gradient(force, dt, axis=0), dt, axis=0)
    return total + static @ second_derivative.T
