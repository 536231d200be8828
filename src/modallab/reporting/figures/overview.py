"""All FRFs of a test at once, and the coherence they were measured with."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from modallab.core.frf import UNIT, Frf
from modallab.reporting.figures import style
from modallab.reporting.figures.shape_data import sensor_label

FEW = 60
"""Up to so many lines an FRF was measured at single frequencies and is drawn with a dot at each."""


def frf_overview(frf: Frf, input_: int = 0, modes_hz: NDArray[np.float64] | None = None) -> Figure:
    """Amplitude of every output over frequency, and the coherence below or beside it if there is any.

    Args:
        frf: as measured.
        input_: which drive point.
        modes_hz: identified frequencies, marked on the axis.
    """
    with style.figure_style():
        figure, axes = style.panel_grid(1 if frf.coherence is None else 2, 2, style.PanelSize(460, 300))
        colours = spread_colours(len(frf.outputs))
        marker = "o" if frf.frequency_hz.size <= FEW else ""
        for i, colour in enumerate(colours):
            name = sensor_label(frf.outputs[i], frf.output_points[i])
            axes[0].plot(
                frf.frequency_hz,
                zero_as_gap(np.abs(frf.values[i, input_])),
                marker=marker,
                linestyle="-",
                color=colour,
                markersize=3,
                linewidth=1.1,
                label=name,
            )
        style.make_logarithmic(axes[0])
        style.label_axes(axes[0], _title(frf, input_), "frequency [Hz]", f"{frf.quantity} [{unit_of_frf(frf)}]")
        if frf.coherence is not None:
            _draw_coherence(axes[1], frf, input_, colours)
        for panel in axes:
            panel.set_xlim(frf.frequency_hz[0], frf.frequency_hz[-1])
            for mode in () if modes_hz is None else modes_hz:
                panel.axvline(float(mode), color=style.SOFT, linewidth=0.8, linestyle=":", zorder=0)
        style.figure_legend(figure, _legend_key(axes[0].lines[: len(colours)]))
    return figure


def spread_colours(n: int) -> list[str]:
    """n colours from the clamp to the tip."""
    if n == 1:
        return [style.MEASURED]
    return [style.PLACES[round(i * (len(style.PLACES) - 1) / (n - 1))] for i in range(n)]


def zero_as_gap(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """For a logarithmic axis: zero becomes a gap."""
    return np.where(values > 0, values, np.nan)


def unit_of_frf(frf: Frf) -> str:
    """The unit of an FRF, set for reading: m/(N·s²)."""
    return UNIT[frf.quantity].replace("^2", "²").replace("N s", "N·s")


def _title(frf: Frf, input_: int) -> str:
    point = frf.input_points[input_]
    return "Amplitude" if point is None else f"Amplitude, force at point {point}"


def _draw_coherence(axes: Axes, frf: Frf, input_: int, colours: list[str]) -> None:
    assert frf.coherence is not None
    for i, colour in enumerate(colours):
        axes.plot(frf.frequency_hz, frf.coherence[i, input_], color=colour, linewidth=1.1)
    averages = frf.averages[input_] if len(frf.averages) > input_ else 0
    style.label_axes(
        axes, f"Coherence of {averages} averages" if averages else "Coherence", "frequency [Hz]", "coherence [1]"
    )
    axes.set_ylim(0, 1.03)


def _legend_key(lines: list[Line2D]) -> list[Line2D]:
    # Ten names say less than the two ends of a scale.
    return lines if len(lines) <= 4 else [lines[0], lines[len(lines) // 2], lines[-1]]
