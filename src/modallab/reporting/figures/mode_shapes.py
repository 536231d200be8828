"""The mode shapes with their uncertainty (figure 6 of the paper)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from modallab.core.arrays import Complex128
from modallab.core.block import Block, Campaign
from modallab.core.digits import significant_digits
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.identification.selection.criteria import nearest_partners
from modallab.modification.deflection import motion_at_points, rotate_to_real, shapes_at_freedoms
from modallab.reporting.figures import style
from modallab.reporting.figures.deflection import project_shape
from modallab.updating.correlation import ModelCorrelation

_DRAWN_PLACES = 60
"""Of a smooth curve."""


@dataclass(frozen=True, eq=False, slots=True)
class BeamShape:
    """One mode shape along the beam.

    Attributes:
        x_m: (n,) places of sensors and forces, ascending.
        phi: (n,) real part at unit modal mass in kg^-1/2, after a turn of the phase that makes it as real as can be.
        quadrature: (n,) imaginary part after that turn: what moves a quarter of a period late.
        sigma: (n,) standard deviation, NaN where not known.
        skew_deg: mean angle, weighted by the squared amplitude, by which points move out of step.
    """

    x_m: NDArray[np.float64]
    phi: NDArray[np.float64]
    quadrature: NDArray[np.float64]
    sigma: NDArray[np.float64]
    skew_deg: float


def beam_shape(model: ModalModel, mode: int, rig: Rig) -> BeamShape | None:
    """One mode's shape, the point with the largest motion positive; None if shapes or places are not known."""
    shapes = shapes_at_freedoms(model, rig)
    if model.shapes is None or shapes is None:
        return None
    places = {p.id: p.x_m for p in rig.points}
    x = np.array([places.get(point, np.nan) for point, _ in shapes[0]])
    phi, sigma = np.asarray(shapes[1][mode]), shapes[2][mode]
    order = np.argsort(x, kind="stable")
    known = order[np.isfinite(x[order]) & np.isfinite(phi[order])]
    if known.size < 2:
        return None
    real = rotate_to_real(phi[known])
    return BeamShape(x[known], real.real, real.imag, sigma[known], _skew_deg(real))


def smooth_curve(x_m: NDArray[np.float64], phi: NDArray[np.float64], clamped: bool) -> NDArray[np.float64]:
    """(2, places) smooth curve through the points, for the eye only; it starts at the clamp if there is one.

    No slope is forced at the clamp: whether it is rigid is a question, not a fact.
    """
    if clamped and x_m[0] > 0:
        x_m, phi = np.concatenate([[0.0], x_m]), np.concatenate([[0.0], phi])
    places, keep = np.unique(x_m, return_index=True)
    fine = np.linspace(places[0], places[-1], _DRAWN_PLACES)
    if places.size < 4:
        return np.array([fine, np.interp(fine, places, phi[keep])])
    return np.array([fine, CubicSpline(places, phi[keep], bc_type="not-a-knot")(fine)])


def _skew_deg(phi: NDArray[np.complex128]) -> float:
    weight = np.abs(phi) ** 2
    angle = np.arctan2(np.abs(phi.imag), np.abs(phi.real))
    return float(np.rad2deg((weight * angle).sum() / weight.sum())) if weight.sum() > 0 else 0.0


PAPER_SINE_HZ = 28 / 1.024
"""27.34 Hz, FFT line 28: the sine test the paper draws."""


def example_block(campaign: Campaign, test: Test) -> Block | None:
    """The block a figure shows: the sine block nearest to the paper's, or the first hit; None if there is none."""
    blocks = campaign.of(test)
    if test == "sine":
        blocks = tuple(b for b in blocks if b.frequency_hz is not None)
        return min(blocks, key=lambda b: abs((b.frequency_hz or 0) - PAPER_SINE_HZ), default=None)
    return blocks[0] if blocks else None


def farthest_sensor(rig: Rig, outputs: tuple[str, ...]) -> int:
    """Place among `outputs` of the sensor farthest from the clamp (the paper's point 10); the last if none has one."""
    x = [distance_from_clamp(rig, name) for name in outputs]
    known = [i for i, value in enumerate(x) if np.isfinite(value)]
    return max(known, key=lambda i: x[i]) if known else len(outputs) - 1


def distance_from_clamp(rig: Rig, output: str) -> float:
    """Distance of a channel from the clamp in m; NaN if its place is not known."""
    point = next((c.point for c in rig.channels if c.name == output), None)
    return float("nan") if point is None else rig.x_of(point)


def sensor_label(output: str, point: int | None) -> str:
    """How a sensor is called in a figure: by its point, else by its channel."""
    return f"Point {point}" if point is not None else f"Channel {output}"


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
