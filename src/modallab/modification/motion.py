"""The motion that forces give: over time, its largest and effective values, with one standard deviation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from modallab.core.arrays import Real
from modallab.core.documents.model_use import ForceKind, ImpulseForce, RandomForce, SineForce, SweepForce
from modallab.core.errors import DataError
from modallab.core.units import Quantity
from modallab.modification.known import KnownStructure
from modallab.modification.response import Between
from modallab.modification.structure import At


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


OCTAVE = 10**0.3
"""Ratio of the centres of two octave bands (IEC 61260-1, base ten)."""


@dataclass(frozen=True, eq=False, repr=False)
class MotionOverTime:
    """Motion over time.

    Attributes:
        values: (points, samples) in SI units.
        dt: s between samples.
        points: of which.
        quantity: displacement, velocity or acceleration.
        band_hz: of the model.
        outside: share of the forces' power outside it, where the model says nothing but what its modes still do.
        deviation: of what is computed of such values, over the structures that the model leaves possible.
    """

    values: Real
    dt: float
    points: tuple[At, ...]
    quantity: Quantity
    band_hz: tuple[float, float]
    outside: float
    deviation: Callable[[Callable[[Real], Real]], Real]

    @classmethod
    def of(
        cls,
        known: KnownStructure,
        force: ArrayLike,
        dt: float,
        at: Sequence[At],
        of: Sequence[At] | None,
        quantity: Quantity = "acceleration",
        between: Between = "band-limited",
        start: Mapping[Quantity, Mapping[At, float]] | None = None,
    ) -> Self:
        """Of forces at points of a structure.

        Args:
            known: the structure.
            force: (samples,) N, or (inputs, samples).
            dt: s between samples.
            at: (inputs,) points of the forces.
            of: points whose motion is asked for; None for all that have a sensor.
            quantity: displacement, velocity or acceleration.
            between: what the force is between its samples.
            start: displacement and velocity of points at the first sample; None for rest.

        Raises:
            DataError: a force that cannot be, or a point that the model does not know.
        """
        forces = np.atleast_2d(np.asarray(force, np.float64))
        if len(forces) != len(at):
            raise DataError(f"{len(forces)} forces at {len(at)} points", remedy="give a row of force for each point")
        asked = list(known.sensors if of is None else of)
        begin = None if start is None else {name: dict(values) for name, values in start.items()}

        def move(one: KnownStructure) -> Real:
            return one.response(forces, dt, at, asked, quantity, between, begin)

        return cls(
            move(known), dt, tuple(asked), quantity, known.model.band_hz,
            _power_outside(forces, dt, known.model.band_hz),
            lambda figure: known.standard_deviation(lambda one: figure(move(one))),
        )  # fmt: skip

    @cached_property
    def sigma(self) -> Real:
        """(points, samples) one standard deviation, by what is uncertain of the model."""
        return self.deviation(lambda values: values)

    @property
    def time(self) -> Real:
        """(samples,) s."""
        return self.dt * np.arange(self.values.shape[1])

    @property
    def names(self) -> tuple[str, ...]:
        """(points,) as figures and tables call them: an axis only where a point moves along several."""
        numbers = [p[0] if isinstance(p, tuple) else p for p in self.points]
        several = len(set(numbers)) < len(numbers)
        pairs = zip(self.points, numbers, strict=True)
        return tuple(f"{n}{p[1]}" if several and isinstance(p, tuple) else str(n) for p, n in pairs)

    @property
    def peak(self) -> Real:
        """(points,) largest absolute value."""
        return self.figures[:, 0]

    @property
    def rms(self) -> Real:
        """(points,) effective value."""
        return self.figures[:, 1]

    @property
    def octaves_hz(self) -> tuple[float, ...]:
        """(octaves,) centres of the octave bands that the model and the step leave whole."""
        low, high = self.band_hz[0], min(self.band_hz[1], 1 / (2 * self.dt))
        low = max(low, 1 / (self.dt * self.values.shape[1]))
        first, last = (np.log(edge / 1e3) / np.log(OCTAVE) for edge in (low, high))
        return tuple(float(1e3 * OCTAVE**k) for k in range(int(np.ceil(first + 0.5)), int(np.floor(last - 0.5)) + 1))

    @cached_property
    def figures(self) -> Real:
        """(points, 2 + octaves) largest value, effective value, effective value in each octave band."""
        return self._figures_of_samples(self.values)

    @cached_property
    def figures_sigma(self) -> Real:
        """(points, 2 + octaves) one standard deviation of `figures`."""
        return self.deviation(self._figures_of_samples)

    def _figures_of_samples(self, values: Real) -> Real:
        peak, rms = np.abs(values).max(axis=1), np.sqrt(np.mean(values**2, axis=1))
        edges = [(centre / OCTAVE**0.5, centre * OCTAVE**0.5) for centre in self.octaves_hz]
        return np.stack([peak, rms, *(self._level(values, *edge) for edge in edges)], axis=1)

    def level(self, low_hz: float, high_hz: float) -> Real:
        """(points,) effective value within a band."""
        return self._level(self.values, low_hz, high_hz)

    def _level(self, values: Real, low_hz: float, high_hz: float) -> Real:
        lines = np.fft.rfftfreq(values.shape[1], self.dt)
        inside = (lines >= low_hz) & (lines <= high_hz)
        spectrum = np.abs(np.fft.rfft(values, axis=1)) / values.shape[1]
        return np.asarray(np.sqrt(2 * np.sum(spectrum[:, inside] ** 2, axis=1)), np.float64)


def _power_outside(forces: Real, dt: float, band_hz: tuple[float, float]) -> float:
    power, hz = np.sum(np.abs(np.fft.rfft(forces, axis=1)) ** 2, axis=0), np.fft.rfftfreq(forces.shape[1], dt)
    inside = float(np.sum(power[(hz >= band_hz[0]) & (hz <= band_hz[1])]))
    return 1 - inside / float(np.sum(power)) if power.any() else 0.0
