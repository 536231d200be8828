"""Measured against regenerated mobility at one point in full (figure 8 of the paper)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modallab.core.model import Verification
from modallab.reporting.figures import style
from modallab.reporting.figures.all_points import Part, draw_mobility, draw_residual
from modallab.reporting.figures.overview import unit_of_frf
from modallab.reporting.figures.shape_data import sensor_label


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
