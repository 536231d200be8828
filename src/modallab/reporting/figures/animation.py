"""Mode shapes that move: one small SVG a mode, still for those who want it still."""

import json

import numpy as np
from numpy.typing import NDArray

from modallab.core.digits import significant_digits, with_nonbreaking_spaces
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.reporting.figures.mode_shapes import BeamShape, beam_shape, smooth_curve
from modallab.reporting.figures.wireframe import moving_pictures
from modallab.reporting.markup import Markup, html_element, trusted_markup

_WIDTH, _HALF, _LEFT, _RIGHT = 300.0, 54.0, 22.0, 12.0
_PERIOD_S = (2.4, 1.7, 1.3, 1.1)
"""Time of one swing on the page: higher modes faster, yet all slow enough to follow."""


def animated_shapes(model: ModalModel, rig: Rig) -> Markup | None:
    """All shapes of a model, moving, with a button to stop them; None if there are none to draw.

    Points out of step move out of step. On paper, without scripts, and for a reader who asked for less motion there
    are the two extremes.
    """
    found = [beam_shape(model, mode, rig) for mode in range(model.n_modes)]
    clamped = rig.model == "cantilever"
    pictures = [
        _moving_picture(i, float(model.frequency_hz[i]), s, clamped) for i, s in enumerate(found) if s is not None
    ]
    if not pictures:
        return None
    return moving_pictures(pictures, "motion", "motion.js")


def _moving_picture(mode: int, frequency_hz: float, found: BeamShape, clamped: bool) -> Markup:
    period = _PERIOD_S[min(mode, len(_PERIOD_S) - 1)]
    slower = frequency_hz * period
    name = f"Mode {mode + 1}, {significant_digits(frequency_hz)} Hz"
    caption = html_element(
        "figcaption",
        html_element("b", with_nonbreaking_spaces(name)),
        html_element("br"),
        f"shown {significant_digits(slower, 2)} times slower",
    )
    return html_element("figure", _drawing_of_shape(found, clamped, period, f"{name}: the beam vibrates"), caption)


def _drawing_of_shape(found: BeamShape, clamped: bool, period_s: float, alt: str) -> Markup:
    real, skew = smooth_curve(found.x_m, found.phi, clamped), smooth_curve(found.x_m, found.quadrature, clamped)
    start, reach = float(real[0, 0]), float(np.abs(real[1]).max()) or 1.0
    across = (_WIDTH - _LEFT - _RIGHT) / (float(real[0, -1]) - start or 1.0)
    beam = np.array([_LEFT + (real[0] - start) * across, -real[1] / reach * _HALF, -skew[1] / reach * _HALF])
    dots = np.array(
        [_LEFT + (found.x_m - start) * across, -found.phi / reach * _HALF, -found.quadrature / reach * _HALF]
    )
    drift_curve = "M" + "L".join(f"{x:.1f} {y:.2f}" for x, y, _ in beam.T)
    # A dot is a line of no length with round ends.
    marks = "".join(f"M{x:.1f} {y:.2f}h0" for x, y, _ in dots.T)
    ghost = f'<path class="ghost" transform="scale(1 -1)" d="{drift_curve}"/>'
    rest = f'<path class="rest" d="M{_LEFT} 0H{_WIDTH - _RIGHT}"/>'
    wall = f'<path class="wall" d="{_clamp_wall()}"/>' if clamped else ""
    view = f"0 {-_HALF - 8:.0f} {_WIDTH:.0f} {2 * _HALF + 16:.0f}"
    return trusted_markup(
        f'<svg viewBox="{view}" role="img" data-period="{period_s:g}">{html_element("title", alt)}{rest}{wall}{ghost}'
        f'<path class="beam" data-p="{_curve_points(beam)}" d="{drift_curve}"/>'
        f'<path class="dots" data-p="{_curve_points(dots)}" d="{marks}"/></svg>'
    )


def _curve_points(drift_curve: NDArray[np.float64]) -> str:
    return json.dumps(drift_curve.T.round(2).tolist(), separators=(",", ":"))


def _clamp_wall() -> str:
    edge = f"M{_LEFT} -34V34"
    return edge + "".join(f"M{_LEFT} {y}l-9 9" for y in range(-34, 34, 8))
