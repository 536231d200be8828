"""The motion that forces give: its numbers, its largest and effective values, beside what was recorded."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.units import SI_UNIT, Quantity
from modallab.modification.structure import At
from modallab.notebook.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False)
class PredictedMotion:
    """Motion over time.

    Attributes:
        values: (points, samples) in SI units.
        dt: s between samples.
        points: of which.
        quantity: displacement, velocity or acceleration.
        deviation: gives `sigma`, which takes fifty times as long as the motion.
    """

    values: Real
    dt: float
    points: tuple[At, ...]
    quantity: Quantity
    deviation: Callable[[], Real]

    @cached_property
    def sigma(self) -> Real:
        """(points, samples) one standard deviation, by what is uncertain of the model."""
        return self.deviation()

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
        return np.asarray(np.abs(self.values).max(axis=1), np.float64)

    @property
    def rms(self) -> Real:
        """(points,) effective value."""
        return np.asarray(np.sqrt(np.mean(self.values**2, axis=1)), np.float64)

    def level(self, low_hz: float, high_hz: float) -> Real:
        """(points,) effective value within a band."""
        lines = np.fft.rfftfreq(self.values.shape[1], self.dt)
        inside = (lines >= low_hz) & (lines <= high_hz)
        spectrum = np.abs(np.fft.rfft(self.values, axis=1)) / self.values.shape[1]
        return np.asarray(np.sqrt(2 * np.sum(spectrum[:, inside] ** 2, axis=1)), np.float64)

    def error(self, recorded: ArrayLike, band_hz: tuple[float, float] | None = None) -> Real:
        """(points,) what a record differs by, as a share of the record; within a band if one is given.

        Args:
            recorded: (points, samples) in the same unit.
            band_hz: lower and upper edge; None for all frequencies.

        Raises:
            DataError: a record of another shape.
        """
        record = np.atleast_2d(np.asarray(recorded, np.float64))
        if record.shape != self.values.shape:
            raise DataError(f"a record of shape {record.shape}", remedy=f"give one of shape {self.values.shape}")
        left, whole = (np.abs(np.fft.rfft(v, axis=1)) for v in (self.values - record, record))
        if band_hz is not None:
            lines = np.fft.rfftfreq(record.shape[1], self.dt)
            inside = (lines >= band_hz[0]) & (lines <= band_hz[1])
            left, whole = left[:, inside], whole[:, inside]
        return np.asarray(np.linalg.norm(left, axis=1) / np.linalg.norm(whole, axis=1), np.float64)

    def table(self) -> Shown:
        """Largest and effective value of every point."""
        unit = SI_UNIT[self.quantity]
        rows = [(name, f"{a:.4g}", f"{b:.4g}") for name, a, b in zip(self.names, self.peak, self.rms, strict=True)]
        caption = f"{self.quantity} over {self.values.shape[1] * self.dt:.4g} s"
        return Shown(("point", f"peak [{unit}]", f"rms [{unit}]"), rows, caption)

    def plot(self) -> "Figure":
        """Every point over time."""
        from modallab.reporting.figures.predicted import motion

        return motion(self.time, self.values, list(self.names), self.quantity)

    def __repr__(self) -> str:
        return f"<PredictedMotion: {self.quantity} of {len(self.points)} points, {self.values.shape[1]} samples>"

    def _repr_html_(self) -> str:
        return self.table().html()
