"""Measured against regenerated mobility, at every point and at one in full (figures 7 and 8 of the paper)."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.digits import four_places
from modallab.core.frf import Frf
from modallab.core.model import Verification
from modallab.reporting.figures import style
from modallab.reporting.figures.overview import FEW, unit_of_frf, zero_as_gap
from modallab.reporting.figures.shape_data import sensor_label

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
        axes.plot(frf.frequency_hz, zero_as_gap(values) if part is np.abs else values, label=name, **options)
    low, high = check.measured.frequency_hz[[0, -1]]
    edge = 0.012 * (high - low)
    axes.set_xlim(low - edge, high + edge)


def draw_residual(axes: Axes, check: Verification, output: int, input_: int) -> None:
    """What the model does not repeat, below the curves of a logarithmic panel."""
    left = np.abs(check.measured.values[output, input_] - check.regenerated.values[output, input_])
    low, high = axes.get_ylim()
    few = check.measured.frequency_hz.size <= FEW
    options: dict[str, Any] = {"marker": "v", "linestyle": "none", "markersize": 4} if few else {"linewidth": 0.9}
    axes.plot(check.measured.frequency_hz, zero_as_gap(left), color=style.SECOND, label="residual", **options)
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


def one_point(check: Verification, output: int, input_: int = 0) -> Figure:
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
