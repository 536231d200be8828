"""The mode shapes with their uncertainty (figure 6 of the paper)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from modallab.core.arrays import Complex128
from modallab.core.digits import significant_digits
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.identification.selection.criteria import nearest_partners
from modallab.modification.deflection import motion_at_points
from modallab.reporting.figures import style
from modallab.reporting.figures.deflection import project_shape
from modallab.reporting.figures.shape_data import BeamShape, beam_shape, smooth_curve
from modallab.updating.correlation import ModelCorrelation

_MARKS = (("o", style.MEASURED), ("s", style.MODEL))


def mode_shapes(models: Sequence[ModalModel], rig: Rig) -> Figure | None:
    """One panel a mode of the first model with shapes; a second test's shapes lie beside them.

    Args:
        models: one a test, two at most are drawn.
        rig: for the places of the sensors and the clamp.

    Returns:
        the figure, or None if no model has shapes at known places.
    """
    drawable = [m for m in models if m.n_modes and beam_shape(m, 0, rig) is not None][:2]
    if not drawable:
        return None
    first = drawable[0]
    with style.figure_style():
        figure, axes = style.panel_grid(first.n_modes, min(3, first.n_modes), style.PanelSize(340, 250))
        for mode, panel in enumerate(axes):
            reference = beam_shape(first, mode, rig)
            for model, mark in zip(drawable, _MARKS, strict=False):
                found = _partner_mode(first, mode, model, rig)
                if found is not None and reference is not None:
                    _draw_shape(panel, _align_sign(found, reference), mark, rig)
            _draw_frame(panel, rig)
            style.label_axes(
                panel,
                f"Mode {mode + 1} · {significant_digits(float(first.frequency_hz[mode]))} Hz",
                "x [m]",
                "φ [kg⁻¹ᐟ²]",
            )
        style.figure_legend(figure, [_legend_key(model, mark) for model, mark in zip(drawable, _MARKS, strict=False)])
    return figure


def _partner_mode(first: ModalModel, mode: int, model: ModalModel, rig: Rig) -> BeamShape | None:
    place = mode if model is first else nearest_partners(first.frequency_hz, model.frequency_hz)[mode]
    return None if place is None else beam_shape(model, place, rig)


def _align_sign(found: BeamShape, reference: BeamShape) -> BeamShape:
    # Two nearly equal extremes can give two tests opposite signs: the first test's sign holds.
    product = np.interp(reference.x_m, found.x_m, found.phi) @ reference.phi
    return found if product >= 0 else replace(found, phi=-found.phi, quadrature=-found.quadrature)


def _draw_shape(axes: Axes, found: BeamShape, mark: tuple[str, str], rig: Rig) -> None:
    symbol, colour = mark
    hollow = symbol != "o"
    axes.plot(*smooth_curve(found.x_m, found.phi, rig.model == "cantilever"), color=colour, linewidth=0.9, alpha=0.7)
    axes.errorbar(
        found.x_m,
        found.phi,
        yerr=np.where(np.isfinite(found.sigma), found.sigma, 0.0),
        fmt=symbol,
        color=colour,
        markerfacecolor="none" if hollow else colour,
        markersize=8 if hollow else 4.5,
        elinewidth=1.4,
        capsize=3,
    )


def _legend_key(model: ModalModel, mark: tuple[str, str]) -> Line2D:
    symbol, colour = mark
    fill = colour if symbol == "o" else "none"
    name = f"{model.test} test" if model.test else "FRFs"
    return Line2D([], [], color=colour, marker=symbol, markerfacecolor=fill, linewidth=0.9, label=f"{name}, ± 1 σ")


def _draw_frame(axes: Axes, rig: Rig) -> None:
    axes.axhline(0, color=style.SOFT, linewidth=0.9, zorder=1)
    if rig.model != "cantilever" or rig.beam is None:
        return
    length, (low, high) = rig.beam.length_m, axes.get_ylim()
    reach = max(-low, high)
    clamp = Rectangle((-0.03 * length, -reach / 3), 0.03 * length, 2 * reach / 3, hatch="////", linewidth=0)
    clamp.set(facecolor="none", edgecolor=style.SOFT, label="_clamp")
    axes.add_patch(clamp)
    axes.plot([0, 0], [-reach / 3, reach / 3], color=style.SOFT, linewidth=1.6)
    axes.set_xlim(-0.04 * length, 1.03 * length)


COLUMNS = 3
LOOKS = (("first model", style.MEASURED, "-"), ("second model", style.MODEL, "--"))


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
            panel.set_title(f"Modes {i + 1} and {j + 1}: {hz[0]:.4g} and {hz[1]:.4g} Hz, MAC {found.mac[i, j]:.3f}")
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
