"""The motion that forces give: shown, written, beside what was recorded."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.formats.prediction import write_motion
from modallab.modification.motion import MotionOverTime
from modallab.notebook.display import DisplayedTable
from modallab.reporting.behaviour_table import motion_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class PredictedMotion(MotionOverTime):
    """Motion over time: `values`, `sigma`, `time`, `peak`, `rms`, `level`."""

    def error_against(self, recorded: ArrayLike, band_hz: tuple[float, float] | None = None) -> Real:
        """(points,) difference to a record, relative to the record; within a band if one is given.

        Args:
            recorded: (points, samples) in the same unit.
            band_hz: lower and upper edge; None for all frequencies.

        Raises:
            DataError: a record with another shape.
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

    def table(self) -> DisplayedTable:
        """Largest value, effective value and octave bands of every point, with one standard deviation."""
        return DisplayedTable(*motion_rows(self))

    def save(self, path: str | Path) -> Path:
        """Write motion and deviation over time as .csv or .mat; returns the path.

        Raises:
            StorageError: the file name has another ending, or the file cannot be written.
        """
        return write_motion(Path(path), self.time, self.values, self.sigma, self.names, self.quantity)

    def plot(self) -> "Figure":
        """Every point over time."""
        from modallab.reporting.figures.mobility import motion_figure

        return motion_figure(self.time, self.values, list(self.names), self.quantity)

    def __repr__(self) -> str:
        return f"<PredictedMotion: {self.quantity} of {len(self.points)} points, {self.values.shape[1]} samples>"

    def _repr_html_(self) -> str:
        return self.table().html()
