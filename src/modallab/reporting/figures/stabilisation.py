"""Stabilisation diagram, CMIF and MIF over one frequency axis."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from modallab.identification.selection.diagram import IN_FREQUENCY, NEW, STABLE, StabilisationData
from modallab.reporting.figures import style
from modallab.reporting.figures.mobility import FEW, hide_zeros

MOST_ORDERS = 40
"""Of more orders every second, third ... is drawn: more marks than these are a smear, and a page of many MB."""
MOST_CURVES = 3

_MARKS: dict[int, tuple[str, str, str, float]] = {
    NEW: ("x", style.SOFT, "pole not present at the order below", 4.0),
    IN_FREQUENCY: ("^", style.MODEL, "frequency holds", 4.5),
    STABLE: ("o", style.MEASURED, "frequency and damping stable", 4.5),
}
_CURVES = (style.MEASURED, style.MODEL, style.THIRD)


def stabilisation_panels(diagram: StabilisationData, modes_hz: NDArray[np.float64], counted: str = "order") -> Figure:
    """Three panels: poles by order, CMIF, and MIF.

    Args:
        diagram: the poles of all orders, and the indicators.
        modes_hz: (modes,) the model's frequencies, marked in every panel.
        counted: what the order counts.
    """
    with style.figure_style():
        figure, axes = style.panel_grid(3, 2, style.PanelSize(460, 300))
        _draw_poles(axes[0], diagram, counted)
        _draw_indicators(axes[1], axes[2], diagram)
        for panel in axes:
            panel.set_xlim(float(diagram.line_hz[0]), float(diagram.line_hz[-1]))
            for mode in modes_hz:
                panel.axvline(float(mode), color=style.SECOND, linewidth=0.9, linestyle="--", zorder=0)
        style.figure_legend(figure, _legend_key(diagram))
    return figure


def _draw_poles(axes: Axes, diagram: StabilisationData, counted: str) -> None:
    drawn = _is_drawn(diagram.order)
    for standing, (marker, colour, _, size) in _MARKS.items():
        here = drawn & (diagram.standing == standing)
        axes.plot(
            diagram.frequency_hz[here],
            diagram.order[here],
            linestyle="none",
            marker=marker,
            color=colour,
            markerfacecolor=colour if marker == "o" else "none",
            markersize=size,
        )
    style.label_axes(axes, "Stabilisation diagram", "frequency [Hz]", f"{counted} [1]")
    axes.set_ylim(0, float(diagram.order.max(initial=1)) * 1.04)


def _is_drawn(order: NDArray[np.int64]) -> NDArray[np.bool_]:
    every = np.unique(order)
    return np.isin(order, every[:: max(1, -(-every.size // MOST_ORDERS))])


def _draw_indicators(above: Axes, below: Axes, diagram: StabilisationData) -> None:
    marker = "o" if diagram.line_hz.size <= FEW else ""
    for i, colour in list(enumerate(_CURVES))[:MOST_CURVES]:
        for axes, curves in ((above, diagram.cmif), (below, diagram.mmif)):
            if i < len(curves):
                axes.plot(
                    diagram.line_hz,
                    hide_zeros(curves[i]),
                    color=colour,
                    marker=marker,
                    markersize=3,
                    linewidth=1.2,
                )
    style.make_logarithmic(above)
    style.label_axes(above, "CMIF", "frequency [Hz]", "squared singular value [m²/(N·s)²]")
    style.label_axes(
        below, "MIF" if len(diagram.mmif) == 1 else "Multivariate MIF", "frequency [Hz]", "in-phase share [1]"
    )
    below.set_ylim(0, 1.03)


def _legend_key(diagram: StabilisationData) -> list[Line2D]:
    handles = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=marker,
            color=colour,
            markerfacecolor=colour if marker == "o" else "none",
            label=says,
        )
        for marker, colour, says, _ in _MARKS.values()
    ]
    several = max(len(diagram.cmif), len(diagram.mmif)) > 1
    curves = ("first curve", "second", "third") if several else ("indicator",)
    handles += [Line2D([], [], color=c, label=t) for c, t in zip(_CURVES, curves, strict=False)]
    return [*handles, Line2D([], [], color=style.SECOND, linestyle="--", label="mode of the model")]
