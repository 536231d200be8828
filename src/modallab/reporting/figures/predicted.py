"""What a modal model predicts: mobility before and after a change, motion over time."""

import numpy as np
from matplotlib.figure import Figure

from modallab.core.arrays import Real
from modallab.core.frf import Frf
from modallab.core.units import SI_UNIT, Quantity
from modallab.reporting.figures import style
from modallab.reporting.figures.overview import spread_colours, zero_as_gap


def before_after(before: Frf, after: Frf) -> Figure:
    """Amplitude of one FRF before a change and after it, with two standard deviations.

    Args:
        before: one output, one input.
        after: on the same lines, with its variance.
    """
    with style.figure_style():
        figure, axes = style.panel_grid(1, 1, style.PanelSize(760, 300))
        for frf, name, colour in ((before, "before", style.SOFT), (after, "after", style.MEASURED)):
            size = np.abs(frf.values[0, 0])
            axes[0].plot(frf.frequency_hz, zero_as_gap(size), color=colour, linewidth=1.2, label=name)
            if frf is after and frf.variance is not None:
                wide = 2 * np.sqrt(frf.variance[0, 0])
                axes[0].fill_between(frf.frequency_hz, zero_as_gap(size - wide), size + wide, color=colour, alpha=0.25)
        style.make_logarithmic(axes[0])
        title = f"Force at {after.input_points[0]}, motion of {after.output_points[0]}"
        style.label_axes(axes[0], title, "frequency [Hz]", "mobility [m/(N·s)]")
        axes[0].legend()
    return figure


def motion_figure(time: Real, values: Real, names: list[str], quantity: Quantity) -> Figure:
    """Motion (points, samples) of every point over time (samples,) in s."""
    with style.figure_style():
        figure, axes = style.panel_grid(1, 1, style.PanelSize(760, 300))
        for row, name, colour in zip(values, names, spread_colours(len(names)), strict=True):
            axes[0].plot(time, row, color=colour, linewidth=0.9, label=f"point {name}")
        style.label_axes(axes[0], quantity.capitalize(), "time [s]", f"{quantity} [{SI_UNIT[quantity]}]")
        axes[0].legend(fontsize="small")
    return figure
