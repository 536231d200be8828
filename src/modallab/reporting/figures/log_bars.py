"""Bars in noise units on a logarithmic axis, one panel."""

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from modallab.core.rounded import rounded
from modallab.reporting.figures import style

AXIS = "rms of measured less simulated [noise units]"
LEAST, SLIVER = 1.0, 1.012
"""Where the axis begins, at noise alone; and how far a bar reaches that is no longer than that."""
ROW, LABELLED, AROUND = 30, 44, 76
"""Height of a row, of one with its label above, and of what is around the rows, in px."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of bars below one another.

    Attributes:
        label: over them.
        values: in noise units, one for each name of the figure; None is left out.
        said: behind the last.
    """

    label: str
    values: tuple[float | None, ...]
    said: str = ""


def log_bars(rows: Sequence[Row], names: Sequence[str], colours: Sequence[str], above: bool = False) -> Figure:
    """The rows from the top, on an axis that begins at 1, the noise.

    Args:
        rows: what is compared.
        names: of the values of each row, for the legend.
        colours: of the values.
        above: whether labels stand over their bars, as long ones must, and not before them.
    """
    most = max([v for row in rows for v in row.values if v is not None] + [10.0])
    height = (LABELLED if above else ROW) * len(rows)
    with style.look():
        figure, (axes,) = style.grid(1, 1, style.Cell(420, AROUND + height))
        for y, row in enumerate(rows):
            _row(axes, y, row, colours, above)
        style.logarithmic(axes, "x")
        axes.set_xlim(LEAST, LEAST * (most / LEAST) ** 1.3)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_yticks(range(len(rows)), [""] * len(rows) if above else [style.shorten(r.label, 9) for r in rows])
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel(AXIS, labelpad=3)
        if len(names) > 1:
            style.legend(figure, [Patch(color=c, label=n) for c, n in zip(colours, names, strict=True)])
    return figure


def _row(axes: Axes, y: int, row: Row, colours: Sequence[str], above: bool) -> None:
    top, each = (-0.1, 0.5) if above else (-0.4, 0.8)
    each /= len(colours)
    if above:
        _write(axes, LEAST, y - 0.28, row.label, 10.5)
    for k, value in enumerate(row.values):
        if value is None:
            continue
        at, last = y + top + each * (k + 0.5), k == len(colours) - 1
        axes.barh(at, max(value, SLIVER) - LEAST, 0.9 * each, left=LEAST, color=colours[k])
        _write(axes, max(value, SLIVER), at, f"{rounded(value)}{row.said if last else ''}", 9.5)


def _write(axes: Axes, x: float, y: float, text: str, size: float) -> None:
    axes.annotate(text, (x, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=size)
