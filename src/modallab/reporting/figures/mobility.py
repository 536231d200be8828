"""Mobility, measured against regenerated (figures 7 and 8 of the paper): one, all at once, or as predicted."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.digits import four_places
from modallab.core.frf import UNIT, Frf
from modallab.core.model import Verification
from modallab.core.units import SI_UNIT, Quantity
from modallab.reporting.figures import style
from modallab.reporting.figures.mode_shapes import sensor_label

Part = Callable[[NDArray[np.complex128]], NDArray[np.float64]]
"""Amplitude, real part or another part of complex numbers."""


def mobility_panels(check: Verification, input_: int = 0) -> Figure:
    """One panel a point: amplitude of measured and regenerated mobility with their FRAC; thin, the untruncated FRF.

    Args:
        check: measured and regenerated mobility.
        input_: which drive point.
    """
    n = len(check.measured.outputs)
    with style.figure_style():
        figure, axes = style.panel_grid(n, min(3, n), style.PanelSize(340, 230))
        for i, panel in enumerate(axes):
            draw_mobility(panel, check, i, input_, np.abs)
            style.make_logarithmic(panel)
            draw_residual(panel, check, i, input_)
            where = sensor_label(check.measured.outputs[i], check.measured.output_points[i])
            style.label_axes(
                panel,
                f"{where} · FRAC {four_places(float(check.frac[i, input_]))}",
                "frequency [Hz]",
                f"mobility [{unit_of_frf(check.measured)}]",
            )
        low = min(panel.get_ylim()[0] for panel in axes)
        high = max(panel.get_ylim()[1] for panel in axes)
        for panel in axes:
            panel.set_ylim(low, high)
        style.figure_legend(figure, axes[0].lines)
    return figure


def draw_mobility(axes: Axes, check: Verification, output: int, input_: int, part: Part) -> None:
    """The three curves of one point, as amplitude, real part or another part of the complex number."""
    few = check.measured.frequency_hz.size <= FEW
    curves: tuple[tuple[Frf, str, dict[str, Any]], ...] = (
        (check.untruncated, "the model itself", {"color": style.SOFT, "linewidth": 0.7, "linestyle": "-"}),
        (check.measured, "measured", _measured_style(few)),
        (check.regenerated, "regenerated through the same block", _regenerated_style(few)),
    )
    for frf, name, options in curves:
        values = part(frf.values[output, input_])
        axes.plot(frf.frequency_hz, hide_zeros(values) if part is np.abs else values, label=name, **options)
    low, high = check.measured.frequency_hz[[0, -1]]
    edge = 0.012 * (high - low)
    axes.set_xlim(low - edge, high + edge)


def draw_residual(axes: Axes, check: Verification, output: int, input_: int) -> None:
    """What the model does not reproduce, below the curves of a logarithmic panel."""
    left = np.abs(check.measured.values[output, input_] - check.regenerated.values[output, input_])
    low, high = axes.get_ylim()
    few = check.measured.frequency_hz.size <= FEW
    options: dict[str, Any] = {"marker": "v", "linestyle": "none", "markersize": 4} if few else {"linewidth": 0.9}
    axes.plot(check.measured.frequency_hz, hide_zeros(left), color=style.SECOND, label="residual", **options)
    # Three decades below the curves are enough to see a residual that matters, and leave these their height.
    seen = left[left > 0]
    axes.set_ylim(max(low / 1000, min(low, float(seen.min()) / 2 if seen.size else low)), high)


def _measured_style(few: bool) -> dict[str, Any]:
    if few:
        return {
            "color": style.MEASURED,
            "linestyle": "none",
            "marker": "o",
            "markersize": 7,
            "markerfacecolor": "none",
            "markeredgewidth": 1.5,
        }
    return {"color": style.MEASURED, "linewidth": 3.6, "alpha": 0.5}


def _regenerated_style(few: bool) -> dict[str, Any]:
    if few:
        return {"color": style.MODEL, "linestyle": "none", "marker": "x", "markersize": 5, "markeredgewidth": 1.4}
    return {"color": style.MODEL, "linewidth": 1.5, "linestyle": "--"}


def frf_at_one_point(check: Verification, output: int, input_: int = 0) -> Figure:
    """Amplitude, phase, real and imaginary part; the paper shows point 10, the free end.

    Args:
        check: measured and regenerated mobility.
        output: place of the response.
        input_: which drive point.
    """
    where = sensor_label(check.measured.outputs[output], check.measured.output_points[output])
    of = f"[{unit_of_frf(check.measured)}]"
    parts = (
        ("amplitude", np.abs, f"mobility {of}"),
        ("phase", _phase_deg, "phase [°]"),
        ("real part", np.real, f"mobility {of}"),
        ("imaginary part", np.imag, f"mobility {of}"),
    )
    with style.figure_style():
        figure, axes = style.panel_grid(4, 2)
        for panel, (name, part, axis) in zip(axes, parts, strict=True):
            draw_mobility(panel, check, output, input_, part)
            if part is np.abs:
                style.make_logarithmic(panel)
                draw_residual(panel, check, output, input_)
            elif part is not _phase_deg:
                _draw_frame(panel, part, check, output, input_)
            style.label_axes(panel, f"{where}, {name}", "frequency [Hz]", axis)
        axes[1].set_yticks(range(-180, 181, 90))
        axes[1].set_ylim(-195, 195)
        style.figure_legend(figure, axes[0].lines)
    return figure


def _draw_frame(axes: Axes, part: Part, check: Verification, output: int, input_: int) -> None:
    # The model's own peaks stand many times above anything a block can show: the axis stays with the block.
    seen = [part(frf.values[output, input_]) for frf in (check.measured, check.regenerated)]
    low, high = min(v.min() for v in seen), max(v.max() for v in seen)
    axes.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))


def _phase_deg(values: np.ndarray) -> np.ndarray:
    return np.angle(values, deg=True)


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
                hide_zeros(np.abs(frf.values[i, input_])),
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


def hide_zeros(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """For a logarithmic axis, which holds no zero: a line breaks there."""
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


def mobility_before_after(before: Frf, after: Frf) -> Figure:
    """Amplitude of one FRF before a change and after it, with two standard deviations.

    Args:
        before: one output, one input.
        after: on the same lines, with its variance.
    """
    with style.figure_style():
        figure, axes = style.panel_grid(1, 1, style.PanelSize(760, 300))
        for frf, name, colour in ((before, "before", style.SOFT), (after, "after", style.MEASURED)):
            size = np.abs(frf.values[0, 0])
            axes[0].plot(frf.frequency_hz, hide_zeros(size), color=colour, linewidth=1.2, label=name)
            if frf is after and frf.variance is not None:
                wide = 2 * np.sqrt(frf.variance[0, 0])
                axes[0].fill_between(frf.frequency_hz, hide_zeros(size - wide), size + wide, color=colour, alpha=0.25)
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
