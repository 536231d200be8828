"""The shapes of two models over each other, a panel for each pair of modes."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from modallab.core.arrays import Complex128
from modallab.core.rig import Rig
from modallab.modification.deflection import motion_at_points
from modallab.reporting.figures import style
from modallab.reporting.figures.deflection import project_shape
from modallab.updating.correlation import ModelCorrelation

COLUMNS = 3
LOOKS = (("the one", style.MEASURED, "-"), ("the other", style.MODEL, "--"))


def paired_shapes(found: ModelCorrelation, rig: Rig) -> Figure:
    """Both shapes of each pair at their largest, over the structure at rest.

    Args:
        found: pairs of modes.
        rig: where the points are.
    """
    with style.figure_style():
        figure, axes = style.panel_grid(len(found.pairs), min(COLUMNS, len(found.pairs)), style.PanelSize(380, 200))
        for n, (panel, (i, j), hz) in enumerate(zip(axes, found.pairs, found.frequency_hz, strict=True)):
            motions = [motion_at_points(rig, found.freedoms, shapes[n]) for shapes in found.shapes]
            _draw_motions(panel, rig, motions)
            panel.set_title(f"{i + 1}: {hz[0]:.5g} Hz, {j + 1}: {hz[1]:.5g} Hz, MAC {found.mac[i, j]:.3f}")
        style.figure_legend(figure, [Line2D([], [], color=c, linestyle=dash, label=name) for name, c, dash in LOOKS])
    return figure


def _draw_motions(axes: Axes, rig: Rig, motions: list[Complex128]) -> None:
    axes.set_axis_off()
    axes.set_aspect("equal")
    for (_, colour, dash), motion in zip(LOOKS, motions, strict=True):
        rest, moved, pairs = project_shape(rig, motion, float(np.abs(motions[0]).max()))
        now = rest + moved.real
        for a, b in pairs:
            axes.plot(*rest[[a, b]].T, color=style.GRID, linewidth=1.0, zorder=1)
            axes.plot(*now[[a, b]].T, color=colour, linestyle=dash, linewidth=1.6, zorder=2)
