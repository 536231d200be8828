"""Forces over time, of the kinds that are asked for by a few numbers."""

from collections.abc import Callable
from typing import Any

import numpy as np

from modallab.core.arrays import Real
from modallab.core.documents.forces import ForceKind, ImpulseForce, RandomForce, SineForce, SweepForce
from modallab.core.errors import DataError


def force_samples(force: ForceKind, step_s: float, count: int) -> Real:
    """(count,) N at every step from 0 on.

    Raises:
        DataError: a sine of fewer than two samples a period, which would be another one.
    """
    fastest = _fastest_sine(force)
    if 2 * fastest * step_s >= 1:
        raise DataError(
            f"steps of {step_s:g} s hold no sine of {fastest:g} Hz", remedy=f"give a step below {0.5 / fastest:.4g} s"
        )
    return np.asarray(KINDS[type(force)](force, step_s * np.arange(count, dtype=np.float64)), np.float64)


def _fastest_sine(force: ForceKind) -> float:
    match force:
        case SineForce():
            return force.frequency_hz
        case SweepForce():
            return max(force.from_hz, force.to_hz)
        case _:
            return 0.0


def _impulse_samples(force: ImpulseForce, time: Real) -> Real:
    samples = np.zeros(time.size)
    samples[1] = force.impulse_n_s / (time[1] - time[0])
    return samples


def _sine_samples(force: SineForce, time: Real) -> Real:
    return force.amplitude_n * np.sin(2 * np.pi * force.frequency_hz * time)


def _sweep_samples(force: SweepForce, time: Real) -> Real:
    rate = (force.to_hz - force.from_hz) / (time[-1] - time[0])
    return force.amplitude_n * np.sin(2 * np.pi * (force.from_hz + rate * time / 2) * time)


def _random_samples(force: RandomForce, time: Real) -> Real:
    """Lines of the spectrum with normal real and imaginary parts: a record that would repeat without a step."""
    n, step = time.size, time[1] - time[0]
    hz, density = np.array(force.spectrum).T
    lines = np.fft.rfftfreq(n, step)
    power = np.interp(lines, hz, density, left=0.0, right=0.0) / (n * step)
    parts = np.random.default_rng(force.seed).standard_normal((2, lines.size))
    return np.fft.irfft(n / 2 * np.sqrt(power) * (parts[0] + 1j * parts[1]), n)


KINDS: dict[type, Callable[[Any, Real], Real]] = {
    ImpulseForce: _impulse_samples,
    SineForce: _sine_samples,
    SweepForce: _sweep_samples,
    RandomForce: _random_samples,
}
