"""Mode shapes that move: one small SVG a mode, moved by the style sheet alone, still for those who want it still."""

from modallab.figures.digits import plain
from modallab.figures.markup import Markup, tag, trusted
from modallab.figures.shape_data import Shape, line, shape
from modallab.schema.model import ModalModel
from modallab.schema.rig import Rig

_WIDTH, _HALF, _LEFT = 300.0, 54.0, 22.0
_PERIOD_S = (2.4, 1.7, 1.3, 1.1)
"""Time of one swing on the page: higher modes faster, yet all slow enough to follow."""


def animated_shapes(model: ModalModel, rig: Rig) -> Markup | None:
    """All shapes of a model, moving, with a switch to stop them; None if there are none to draw.

    A real shape moves as a whole: every point by the same cosine, which is a mere scaling of the picture. So no script
    is needed; paper and a reader who asked for less motion get the two extremes.
    """
    found = [shape(model, mode, rig) for mode in range(model.n_modes)]
    pictures = [
        _picture(i, float(model.frequency_hz[i]), s, rig.model == "cantilever")
        for i, s in enumerate(found)
        if s is not None
    ]
    if not pictures:
        return None
    switch = tag("label", tag("input", type="checkbox", class_="still"), " Hold still")
    return tag("div", switch, tag("div", *pictures, class_="beams"), class_="motion")


def _picture(mode: int, frequency_hz: float, found: Shape, clamped: bool) -> Markup:
    period = _PERIOD_S[min(mode, len(_PERIOD_S) - 1)]
    slower = frequency_hz * period
    name = f"Mode {mode + 1}, {plain(frequency_hz)} Hz"
    caption = tag("figcaption", tag("b", name), tag("br"), f"shown {plain(slower, 2)} times slower")
    return tag("figure", _drawing(found, clamped, period, f"{name}: the beam swings to and fro"), caption)


def _drawing(found: Shape, clamped: bool, period_s: float, alt: str) -> Markup:
    curve = line(found.x_m, found.phi, clamped)
    length, reach = float(curve[0, -1] - curve[0, 0]) or 1.0, float(abs(curve[1]).max()) or 1.0
    start = float(curve[0, 0])

    def xy(x: float, y: float) -> str:
        return f"{_LEFT + (x - start) / length * (_WIDTH - _LEFT - 12):.1f} {-y / reach * _HALF:.1f}"

    beam = "M" + "L".join(xy(x, y) for x, y in curve.T)
    # A dot is a line of no length with round ends: unlike a circle it stays round when the picture is scaled.
    dots = "".join(f"M{xy(x, y)}h0" for x, y in zip(found.x_m, found.phi, strict=True))
    moving = f'<path class="beam" d="{beam}"/><path class="dots" d="{dots}"/>'
    rest = f'<path class="rest" d="M{_LEFT} 0H{_WIDTH - 12}"/>'
    ghost = f'<g transform="scale(1 -1)" class="ghost"><path class="beam" d="{beam}"/></g>'
    wall = f'<path class="wall" d="{_wall()}"/>' if clamped else ""
    view = f"0 {-_HALF - 8:.0f} {_WIDTH:.0f} {2 * _HALF + 16:.0f}"
    label = tag("title", alt)
    return trusted(
        f'<svg viewBox="{view}" role="img">{label}{rest}{wall}{ghost}'
        f'<g class="swing" style="animation-duration:{period_s / 2:g}s">{moving}</g></svg>'
    )


def _wall() -> str:
    edge = f"M{_LEFT} -34V34"
    return edge + "".join(f"M{_LEFT} {y}l-9 9" for y in range(-34, 34, 8))
