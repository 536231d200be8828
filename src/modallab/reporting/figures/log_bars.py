"""Bars on a logarithmic axis, one panel: in noise units, or as shares of the response."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from modallab.core.digits import three_digits
from modallab.reporting.figures import style

SLIVER = 1.012
"""How far a bar reaches that is no longer than where the axis begins, over that."""
BAR, BETWEEN, LABELLED, AROUND = 13, 4, 44, 76
"""Height of a bar, of what is between rows, of a row with its label above, and of what is around all rows, in px."""


@dataclass(frozen=True, slots=True)
class BarScale:
    """What the bars are measured in.

    Attributes:
        label: of the axis.
        least: where it begins.
        most: it reaches at least as far.
        said: a value in words.
    """

    label: str
    least: float
    most: float
    shown: Callable[[float], str]


NOISE = BarScale("rms of measured less simulated [noise units]", 1.0, 10.0, three_digits)
"""From noise alone."""


@dataclass(frozen=True, slots=True)
class BarRow:
    """A row of bars below one another.

    Attributes:
        label: over them.
        values: one for each name of the figure; None is left out.
        said: behind the last.
    """

    label: str
    values: tuple[float | None, ...]
    shown: str = ""


def log_bars(
    rows: Sequence[BarRow], names: Sequence[str], colours: Sequence[str], above: bool = False, scale: BarScale = NOISE
) -> Figure:
    """The rows from the top, on one axis.

    Args:
        rows: what is compared.
        names: of the values of each row, for the legend.
        colours: of the values.
        above: whether labels stand over their bars, as long ones must, and not before them.
        scale: of the axis.
    """
    most = max([v for row in rows for v in row.values if v is not None] + [scale.most])
    height = (LABELLED if above else BAR * len(colours) + BETWEEN) * len(rows)
    with style.figure_style():
        figure, (axes,) = style.panel_grid(1, 1, style.PanelSize(420, AROUND + height))
        for y, row in enumerate(rows):
            _draw_row(axes, y, row, colours, above, scale)
        style.make_logarithmic(axes, "x")
        axes.set_xlim(scale.least, scale.least * (most / scale.least) ** 1.3)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_yticks(range(len(rows)), [""] * len(rows) if above else [style.shorten_text(r.label, 9) for r in rows])
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        axes.set_xlabel(scale.label, labelpad=3)
        if len(names) > 1:
            style.figure_legend(figure, [Patch(color=c, label=n) for c, n in zip(colours, names, strict=True)])
    return figure


def _draw_row(axes: Axes, y: int, row: BarRow, colours: Sequence[str], above: bool, scale: BarScale) -> None:
    top, each = (-0.1, 0.5) if above else (-0.4, 0.8)
    each /= len(colours)
    if above:
        _write_value(axes, scale.least, y - 0.28, row.label, 10.5)
    for k, value in enumerate(row.values):
        if value is None:
            continue
        at, last = y + top + each * (k + 0.5), k == len(colours) - 1
        end = max(value, SLIVER * scale.least)
        axes.barh(at, end - scale.least, 0.9 * each, left=scale.least, color=colours[k])
        _write_value(axes, end, at, f"{scale.shown(value)}{row.shown if last else ''}", 9.5)


def _write_value(axes: Axes, x: float, y: float, text: str, size: float) -> None:
    axes.annotate(text, (x, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=size)
