"""FRFs that were measured elsewhere, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, UNIT, Frf, FrfQuantity
from modallab.core.rig import Channel, Point, Rig
from modallab.notebook.shown import Shown

OUTPUT_UNIT: dict[FrfQuantity, tuple[str, str]] = {
    "receptance": ("displacement", "m"),
    "mobility": ("velocity", "m/s"),
    "inertance": ("acceleration", "m/s^2"),
}


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class MeasuredFrf:
    """FRFs of a structure, ready to be identified.

    Attributes:
        frf: the FRFs as every stage of modallab takes them, (outputs, inputs, lines).
        rig: the structure as far as it is known: outputs and their points.
    """

    frf: Frf
    rig: Rig

    @property
    def campaign(self) -> Campaign:
        """As a campaign without records."""
        return Campaign(self.rig, (), (self.frf,), source="arrays")

    def plot(self) -> Any:
        """Amplitude of every output over frequency, as a matplotlib figure."""
        from modallab.reporting.figures.overview import frf_overview

        return frf_overview(self.frf)

    def table(self) -> Shown:
        """What they are."""
        outputs, inputs, lines = self.frf.values.shape
        low, high = self.frf.frequency_hz[[0, -1]]
        row = (self.frf.quantity, str(outputs), str(inputs), str(lines), f"{low:g} to {high:g} Hz")
        return Shown(("FRFs", "outputs", "inputs", "lines", "band"), [row], f"in {UNIT[self.frf.quantity]}")

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
        inputs: number of the point of each force; one that is also an output's makes modal masses known.
        outputs: number of the point of each response; without them the outputs are numbered from 1.
        quantity: inertance, mobility or receptance.

    Raises:
        DataError: shapes or numbers that do not go together, or no FRF at all.
    """
    lines = np.atleast_1d(np.asarray(f, dtype=np.float64))
    values = _ordered(np.asarray(H), lines)
    if quantity not in DERIVATIVES:
        raise DataError(f"no FRF is called {quantity!r}", remedy=f"use one of {', '.join(DERIVATIVES)}")
    if not np.iscomplexobj(np.asarray(H)):
        raise DataError("the FRFs are real numbers: without a phase there is no mode to find", remedy="give H complex")
    if not lines.size or not np.isfinite(lines).all() or (np.diff(lines) <= 0).any() or lines[0] < 0:
        raise DataError("the frequencies do not ascend from 0 on", where="f", remedy="sort f and H by frequency")
    to = _points(outputs, values.shape[0], "outputs") or tuple(range(1, values.shape[0] + 1))
    of = _points([inputs] if isinstance(inputs, int) else inputs, values.shape[1], "inputs")
    names = tuple(f"y{point}" for point in to)
    known = of or (None,) * values.shape[1]
    return MeasuredFrf(Frf(lines, values, quantity, names, to, known), _bare_rig(names, to, of, quantity))


def _ordered(values: NDArray[Any], lines: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(outputs, inputs, lines), whichever way they lay."""
    if not 1 <= values.ndim <= 3 or lines.size not in (values.shape[0], values.shape[-1]):
        raise DataError(
            f"H of shape {values.shape} does not fit {lines.size} frequencies",
            where="H",
            remedy="give it as (outputs, inputs, lines)",
        )
    if values.shape[-1] != lines.size:
        values = np.moveaxis(values, 0, -1)
    shape = {1: (1, 1, -1), 2: (values.shape[0], 1, -1), 3: values.shape}[values.ndim]
    return np.ascontiguousarray(values.reshape(shape), dtype=np.complex128)


def _points(given: Sequence[int] | None, count: int, which: str) -> tuple[int, ...]:
    if given is None:
        return ()
    points = tuple(int(point) for point in given)
    if len(points) != count or min(points) < 1 or (which == "outputs" and len(set(points)) != count):
        raise DataError(
            f"{which}={list(points)} for {count} {which} of H",
            remedy=f"give {count} numbers of points from 1 on, one for each, in the order of H",
        )
    return points


def _bare_rig(names: Sequence[str], to: Sequence[int], of: Sequence[int], quantity: FrfQuantity) -> Rig:
    measured, unit = OUTPUT_UNIT[quantity]
    force = Channel.model_validate({"index": 0, "name": "force", "quantity": "force", "unit": "N"})
    responses = [
        Channel.model_validate({"index": i, "name": name, "quantity": measured, "unit": unit, "point": point})
        for i, (name, point) in enumerate(zip(names, to, strict=True), 1)
    ]
    # Places are not known: the numbers of the points stand for them in figures.
    points = tuple(Point(id=p, x_m=float(p)) for p in sorted({*to, *of}))
    return Rig(name="FRFs from arrays", model="unknown", points=points, channels=(force, *responses))
