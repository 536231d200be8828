"""FRFs that were measured elsewhere, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, UNIT, Frf, FrfQuantity
from modallab.core.rig import Rig
from modallab.formats.frf_file import rig_of, rig_without_places, write_frf
from modallab.notebook.display import DisplayedTable


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class MeasuredFrf:
    """FRFs of a structure, ready to be identified.

    Attributes:
        frf: FRFs for all stages of modallab, (outputs, inputs, lines).
        rig: outputs and their points.
    """

    frf: Frf
    rig: Rig

    @property
    def campaign(self) -> Campaign:
        """The FRFs as a campaign without records."""
        return Campaign(self.rig, (), (self.frf,), source="arrays")

    @classmethod
    def of(cls, frf: Frf) -> "MeasuredFrf":
        """FRFs between points, whose places are not known."""
        return cls(frf, rig_of(frf))

    def save(self, path: str | Path) -> Path:
        """Write the FRFs: a universal file (.uff), MATLAB's (.mat) or a campaign file (.h5); returns the path.

        Raises:
            StorageError: the file cannot be written, or its name has another ending.
        """
        path = Path(path)
        write_frf(path, self.frf, self.rig)
        return path

    def plot(self) -> Any:
        """Amplitude of every output over frequency, as a matplotlib figure."""
        from modallab.reporting.figures.mobility import frf_overview

        return frf_overview(self.frf)

    def table(self) -> DisplayedTable:
        """Table of the FRFs."""
        outputs, inputs, lines = self.frf.values.shape
        low, high = self.frf.frequency_hz[[0, -1]]
        row = (self.frf.quantity, str(outputs), str(inputs), str(lines), f"{low:g} to {high:g} Hz")
        return DisplayedTable(("FRFs", "outputs", "inputs", "lines", "band"), [row], f"in {UNIT[self.frf.quantity]}")

    def __repr__(self) -> str:
        outputs, inputs, lines = self.frf.values.shape
        return f"<MeasuredFrf: {self.frf.quantity}, {outputs} outputs, {inputs} inputs, {lines} lines>"

    def _repr_html_(self) -> str:
        return self.table().html()


def frf(
    f: ArrayLike,
    H: ArrayLike,
    inputs: Sequence[int] | int | None = None,
    outputs: Sequence[int] | None = None,
    quantity: FrfQuantity = "inertance",
) -> MeasuredFrf:
    """FRFs from arrays.

    Args:
        f: (lines,) frequencies in Hz, ascending.
        H: (outputs, inputs, lines), (outputs, lines) of one input, (lines,) of one FRF, or these with the lines first;
            complex, SI.
        inputs: number of the point of each force; a point that is also an output gives modal masses.
        outputs: number of the point of each response (default: 1, 2, ...).
        quantity: inertance, mobility or receptance.

    Raises:
        DataError: shapes or numbers that do not fit, or no FRF.
    """
    lines, given = np.atleast_1d(_numbers(f, "f")), _numbers(H, "H")
    if lines.ndim > 1:
        raise DataError(f"f has the shape {lines.shape}", remedy="give f with shape (lines,), such as f.ravel()")
    values = _outputs_inputs_lines(given, lines)
    if quantity not in DERIVATIVES:
        raise DataError(f"no FRF is called {quantity!r}", remedy=f"use one of {', '.join(DERIVATIVES)}")
    if not np.iscomplexobj(given):
        raise DataError("the FRFs are real numbers: modes cannot be found without the phase", remedy="give H complex")
    if not lines.size or not np.isfinite(lines).all() or (np.diff(lines) <= 0).any() or lines[0] < 0:
        raise DataError("the frequencies do not ascend from 0 on", where="f", remedy="sort f and H by frequency")
    if not np.isfinite(values).all():
        found = int(np.count_nonzero(~np.isfinite(values)))
        raise DataError(
            f"H holds {found} values that are not finite",
            remedy="leave these lines out of f and H, or leave out a channel without finite values",
        )
    to = _points_of(outputs, values.shape[0], "outputs") or tuple(range(1, values.shape[0] + 1))
    of = _points_of([inputs] if isinstance(inputs, int) else inputs, values.shape[1], "inputs")
    names = tuple(f"y{point}" for point in to)
    known = of or (None,) * values.shape[1]
    return MeasuredFrf(Frf(lines, values, quantity, names, to, known), rig_without_places(names, to, of, quantity))


def phase_increases(frf: Frf) -> bool:
    """Whether the phase rises through the largest peak of most FRFs, as it does where H is that of exp(-i omega t).

    The FRF of a mode that decays runs through its circle clockwise: D. J. Ewins, Modal Testing (2000), section 2.7.
    """
    rows = frf.values.reshape(-1, frf.values.shape[-1])
    if rows.shape[1] < 3:
        return False
    peak = np.clip(np.argmax(np.abs(rows), axis=1), 1, rows.shape[1] - 2)
    at = np.arange(len(rows))
    turn = np.angle(rows[at, peak + 1] * rows[at, peak - 1].conj())
    return bool(np.mean(turn > 0) > 0.5)


def _numbers(given: ArrayLike, name: str) -> NDArray[Any]:
    try:
        found = np.asarray(given)
        return found.astype(np.complex128 if np.iscomplexobj(found) else np.float64)
    except (TypeError, ValueError) as error:
        raise DataError(
            f"{name} is no array of numbers: {error}", remedy="give a NumPy array, or lists of one length"
        ) from error


def _outputs_inputs_lines(values: NDArray[Any], lines: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(outputs, inputs, lines), from either order of the axes."""
    if not 1 <= values.ndim <= 3 or lines.size not in (values.shape[0], values.shape[-1]):
        raise DataError(
            f"H of shape {values.shape} does not fit {lines.size} frequencies",
            remedy="give H with shape (outputs, inputs, lines)",
        )
    if values.shape[-1] != lines.size:
        values = np.moveaxis(values, 0, -1)
    shape = {1: (1, 1, -1), 2: (values.shape[0], 1, -1), 3: values.shape}[values.ndim]
    return np.ascontiguousarray(values.reshape(shape), dtype=np.complex128)


def _points_of(given: Sequence[int] | None, count: int, which: str) -> tuple[int, ...]:
    if given is None:
        return ()
    points = tuple(given)
    if not all(isinstance(point, int | np.integer) for point in points):
        raise DataError(
            f"{which}={list(points)} are not point numbers", remedy=f"number the points from 1 on: {which}=[1, 2, 3]"
        )
    if len(points) != count or min(points) < 1 or (which == "outputs" and len(set(points)) != count):
        raise DataError(
            f"{which}={list(points)} for {count} {which} of H",
            remedy=f"give {count} different numbers of points from 1 on, in the order of H",
        )
    return points
