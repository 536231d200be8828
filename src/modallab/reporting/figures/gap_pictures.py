"""The bench of a diagnosis with the place marked, as SVG in the colours of the page."""

from collections.abc import Callable

from modallab.core.diagnosis import GapLocation
from modallab.core.rig import Channel, Rig
from modallab.reporting.markup import Markup, html_element

WIDTH = 420
"""Of the drawing's own units: about a phone's, so that its text is legible there."""
LEFT, RIGHT = 44, 404
"""Clamp and tip."""
STAGES = ("excitation", "structure", "sensor", "acquisition")
HALF_LABEL = 28
"""Half of what a place takes beside the clamp."""
LETTER = 7.0
"""Width of a letter of 12 units."""


def bench_picture(rig: Rig, where: GapLocation, within_m: tuple[float, float] | None = None) -> Markup:
    """The beam with its clamp, accelerometers and shaker, the chain below, what is concerned marked.

    Args:
        rig: what stands on the bench.
        where: the gap lies.
        within_m: 95 % interval of the place.
    """
    length = rig.beam.length_m if rig.beam is not None else max((p.x_m for p in rig.points), default=1.0)

    def at(x: float) -> float:
        return LEFT + (RIGHT - LEFT) * x / length

    structure = where.stage == "structure"
    parts: list[Markup] = [
        _draw_rectangle(20, 44, 24, 62, "soft", structure and where.x_m == 0.0),
        _draw_rectangle(LEFT, 70, RIGHT - LEFT, 10, "measured", structure and where.x_m is None),
        _draw_text(4, 36, "clamp", "start"),
    ]
    parts += _draw_sensors(rig, where, at)
    if rig.shaker_point is not None:
        parts += _draw_shaker(at(rig.x_of(rig.shaker_point)), where.stage == "excitation")
    if within_m is not None and where.x_m is not None:
        low, high = (at(min(max(v, 0.0), length)) for v in within_m)
        parts.append(_draw_rectangle(low, 84, max(high - low, 1.0), 4, "warning", True))
    if where.x_m is not None:
        parts += _draw_place(at(where.x_m), f"{where.x_m:.3f} m")
    return html_element(
        "svg",
        *parts,
        *_draw_chain(where),
        viewBox=f"0 0 {WIDTH} 190",
        width="100%",
        role="img",
        aria_label="The bench with the place marked",
    )


def _draw_shaker(x: float, hot: bool) -> list[Markup]:
    return [
        _draw_line(x, 80, x, 104, "warning" if hot else "ink"),
        _draw_rectangle(x - 16, 104, 32, 20, "soft", hot),
        _draw_text(x, 138, "shaker, hammer and floor" if hot else "shaker", "middle", hot),
    ]


def _draw_place(x: float, label: str) -> list[Markup]:
    return [
        html_element(
            "circle", cx=f"{x:.1f}", cy="75", r="14", fill="none", stroke="var(--warning)", stroke_width="2.5"
        ),
        # Beside the clamp, not on it.
        _draw_text(min(max(x, LEFT + HALF_LABEL), RIGHT - 16), 104, label, "middle", True),
    ]


def _draw_sensors(rig: Rig, where: GapLocation, at: Callable[[float], float]) -> list[Markup]:
    marked = set(where.channels)
    placed = [(c, at(rig.x_of(c.point))) for c in rig.responses if c.point is not None]
    parts = [_draw_rectangle(x - 6, 58, 12, 12, "ink", c.name in marked) for c, x in placed]
    parts += [_draw_text(x, 52, c.name, "middle", c.name in marked) for c, x in _readable_names(placed, marked)]
    return parts


def _readable_names(placed: list[tuple[Channel, float]], marked: set[str]) -> list[tuple[Channel, float]]:
    """Those whose names do not run into one another, what is concerned first."""
    kept: list[tuple[Channel, float]] = []
    for one, x in sorted(placed, key=lambda p: p[0].name not in marked):
        if all(abs(x - other) > LETTER * (len(one.name) + len(c.name)) / 2 + 3 for c, other in kept):
            kept.append((one, x))
    return kept


def _draw_chain(where: GapLocation) -> list[Markup]:
    parts: list[Markup] = []
    for i, stage in enumerate(STAGES):
        x, hot = 8 + i * 104, where.stage == stage
        parts.append(
            html_element(
                "rect", x=str(x), y="152", width="88", height="28", rx="5",
                fill="var(--warning)" if hot else "var(--shade)", stroke="var(--soft)",
            )
        )  # fmt: skip
        colour = "var(--paper)" if hot else "var(--ink)"
        parts.append(
            html_element("text", stage, x=str(x + 44), y="170", text_anchor="middle", fill=colour, font_size="12")
        )
        if i < len(STAGES) - 1:
            parts.append(_draw_line(x + 89, 166, x + 103, 166, "soft"))
    return parts


def _draw_rectangle(x: float, y: float, width: float, height: float, colour: str, hot: bool) -> Markup:
    return html_element(
        "rect",
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        width=f"{width:.1f}",
        height=f"{height:.1f}",
        rx="2",
        fill="var(--warning)" if hot else f"var(--{colour})",
    )


def _draw_line(x1: float, y1: float, x2: float, y2: float, colour: str) -> Markup:
    return html_element(
        "line",
        x1=f"{x1:.1f}",
        y1=f"{y1:.1f}",
        x2=f"{x2:.1f}",
        y2=f"{y2:.1f}",
        stroke=f"var(--{colour})",
        stroke_width="2",
    )


def _draw_text(x: float, y: float, text: str, anchor: str, hot: bool = False) -> Markup:
    return html_element(
        "text",
        text,
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        text_anchor=anchor,
        font_size="12",
        fill="var(--warning)" if hot else "var(--ink)",
        font_weight="600" if hot else "400",
    )
