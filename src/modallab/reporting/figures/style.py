"""The common look of all figures: colours, sizes, frames.

A figure is a grid of equal cells, each a panel that stands by itself with its own axes and units. So a page can set the
same panels side by side on a wide screen and below one another on a phone. Lengths are in px: 72 an inch.
"""

import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from modallab.core.digits import superscript_text

PX_PER_INCH = 72
LEFT, RIGHT, BOTTOM, TOP = 62, 18, 44, 28
"""What axes keep free within their cell for ticks, labels and title."""
LEGEND = 30
"""Height of the strip above the cells that holds the legend."""

# Okabe and Ito's hues, distinct in every kind of colour vision, each darkened for white and lightened for black; and
# matplotlib's viridis, whose lightness rises evenly, for what has an order from the clamp to the tip.
COLOURS: dict[str, tuple[str, str]] = {
    "ink": ("#1d2733", "#e8edf3"),
    "soft": ("#5b6876", "#a3b0be"),
    "grid": ("#dfe4ea", "#2f3a47"),
    "shade": ("#e9edf2", "#27313d"),
    "paper": ("#fefefe", "#161c24"),
    "measured": ("#0a6fb0", "#56b4e9"),
    "model": ("#c9500a", "#f39c4f"),
    "second": ("#00845f", "#35c49a"),
    "warning": ("#b5266f", "#ee7fb5"),
    "third": ("#8a6d00", "#e0c34a"),
    "place0": ("#440154", "#8a6fd1"),
    "place1": ("#482173", "#7d83d9"),
    "place2": ("#433e85", "#6d97d6"),
    "place3": ("#38588c", "#5eaacc"),
    "place4": ("#2d708e", "#54bbbf"),
    "place5": ("#25858e", "#52c9ad"),
    "place6": ("#1e9b8a", "#67d495"),
    "place7": ("#2cb17e", "#8cdc7a"),
    "place8": ("#52c569", "#b9e164"),
    "place9": ("#86d549", "#e5e35c"),
}
"""Every colour by name: on a light page, on a dark one."""
INK, SOFT, GRID, SHADE, PAPER = (COLOURS[name][0] for name in ("ink", "soft", "grid", "shade", "paper"))
MEASURED, MODEL, SECOND, WARNING, THIRD = (
    COLOURS[name][0] for name in ("measured", "model", "second", "warning", "third")
)
PLACES = tuple(COLOURS[f"place{i}"][0] for i in range(10))

RC: dict[Any, Any] = {
    "font.size": 11.0,
    "font.family": ["DejaVu Sans"],
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 7.0,
    "axes.titley": 1.0,  # else matplotlib measures all ticks to find it a place
    "axes.labelsize": 10.5,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "axes.formatter.use_mathtext": False,
    "figure.facecolor": PAPER,
    "figure.dpi": PX_PER_INCH,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "legend.frameon": False,
    "legend.fontsize": 10.5,
    "legend.labelcolor": INK,
    "lines.linewidth": 1.5,
    "lines.solid_capstyle": "round",
    "path.simplify": True,
    "path.simplify_threshold": 0.4,
    "text.color": INK,
    "text.parse_math": False,  # a name from a file may hold dollar signs
    "xtick.color": SOFT,
    "xtick.labelcolor": INK,
    "xtick.labelsize": 10.0,
    "ytick.color": SOFT,
    "ytick.labelcolor": INK,
    "ytick.labelsize": 10.0,
    "svg.fonttype": "none",
}

_LOCK = threading.RLock()


@contextmanager
def figure_style() -> Generator[None]:
    """The settings above, for as long as a figure is made or written.

    Matplotlib keeps its settings for the whole process, so only one thread at a time draws.
    """
    with _LOCK, mpl.rc_context(RC):
        yield


@dataclass(frozen=True, slots=True)
class PanelSize:
    """Size of one panel with its labels, in px."""

    width: int = 420
    height: int = 270


def panel_grid(n: int, columns: int, cell: PanelSize | None = None) -> tuple[Figure, list[Axes]]:
    """A figure of n cells in rows, with a strip above for the legend.

    Returns:
        the figure and its n axes, in reading order.
    """
    cell = cell or PanelSize()
    rows = -(-n // columns)
    width, height = columns * cell.width, rows * cell.height + LEGEND
    figure = Figure(figsize=(width / PX_PER_INCH, height / PX_PER_INCH))
    axes: list[Axes] = []
    for i in range(n):
        row, column = divmod(i, columns)
        box = (
            (column * cell.width + LEFT) / width,
            ((rows - 1 - row) * cell.height + BOTTOM) / height,
            (cell.width - LEFT - RIGHT) / width,
            (cell.height - BOTTOM - TOP) / height,
        )
        axes.append(figure.add_axes(box))
    return figure, axes


def label_axes(axes: Axes, title: str, x: str, y: str) -> None:
    """Title and axis labels; both labels carry a unit."""
    axes.set_title(shorten_text(title))
    axes.set_xlabel(x, labelpad=3)
    axes.set_ylabel(y)
    # A fixed place keeps the label inside its cell whatever the tick labels are.
    axes.yaxis.set_label_coords(-(LEFT - 12) / axes.get_window_extent().width, 0.5)


def make_logarithmic(axes: Axes, which: str = "y") -> None:
    """A logarithmic axis with plain labels: 0.01, 1, 100 or 10⁻⁷."""
    axes.set_yscale("log") if which == "y" else axes.set_xscale("log")
    axis = axes.yaxis if which == "y" else axes.xaxis
    low, high = sorted(axis.get_view_interval())
    # Within two decades a label at each power of ten leaves the axis nearly bare.
    narrow = low > 0 and high / low < (60 if which == "y" else 2000)
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if narrow else (1,), numticks=12 if narrow else 6))
    axis.set_major_formatter(FuncFormatter(_power_label))
    axis.set_minor_formatter(NullFormatter())
    axis.set_minor_locator(LogLocator(subs=()))


def figure_legend(figure: Figure, handles: Sequence[Any]) -> None:
    """One legend for the whole figure, in the strip above its cells."""
    figure.legend(handles=list(handles), loc="upper left", ncols=6, borderaxespad=0.4, handlelength=2.2)


def shorten_text(text: str, length: int = 44) -> str:
    """A text that fits over a panel."""
    return text if len(text) <= length else text[: length - 1] + "…"


def _power_label(value: float, _place: int | None = None) -> str:
    if 1e-3 < value < 1e4:
        return f"{value:g}"
    mantissa, exponent = f"{value:.0e}".split("e")
    lead = "" if mantissa == "1" else f"{mantissa}·"
    return f"{lead}10{superscript_text(int(exponent))}"
