"""The pictures of a diagnosis, as SVG in the colours of the page."""

import math

from modallab.core.diagnosis import Budget, Shrink, Where
from modallab.core.rig import Rig
from modallab.reporting.markup import Markup, tag

WIDTH = 760
LONGEST = 12
"""Bars of a budget."""


def bench_picture(rig: Rig, where: Where) -> Markup:
    """The beam with its clamp, accelerometers, hit and shaker, the chain below, what is concerned marked."""
    length = rig.beam.length_m if rig.beam is not None else max((p.x_m for p in rig.points), default=1.0)

    def at(x: float) -> float:
        return 90 + 600 * x / length

    marked = set(where.channels)
    parts: list[Markup] = [
        _rect(60, 60, 30, 90, "soft", where.stage == "structure" and where.x_m is not None and where.x_m == 0.0),
        _rect(90, 98, 600, 14, "measured", where.stage == "structure" and where.x_m is None),
        _text(75, 48, "clamp", "middle"),
    ]
    for channel in rig.responses:
        if channel.point is None:
            continue
        x = at(rig.x_of(channel.point))
        hot = channel.name in marked
        parts.append(_rect(x - 9, 80, 18, 18, "warning" if hot else "ink", hot))
        parts.append(_text(x, 72, channel.name, "middle", hot))
    if rig.shaker_point is not None:
        x, hot = at(rig.x_of(rig.shaker_point)), where.stage == "excitation"
        parts += [
            _line(x, 112, x, 150, "warning" if hot else "ink"),
            _rect(x - 20, 150, 40, 26, "warning" if hot else "soft", hot),
            _text(x, 192, "shaker, hammer and floor" if hot else "shaker", "middle", hot),
        ]
    if where.x_m is not None:
        x = at(where.x_m)
        parts.append(
            tag("circle", cx=f"{x:.1f}", cy="105", r="20", fill="none", stroke="var(--warning)", stroke_width="3")
        )
        parts.append(_text(min(max(x, 90), 640), 142, f"{where.x_m:.3f} m", "middle", True))
    parts += _chain(where)
    return tag(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH} 290",
        width="100%",
        role="img",
        aria_label="The bench with the place marked",
    )


def _chain(where: Where) -> list[Markup]:
    stages = ("excitation", "structure", "sensor", "acquisition")
    parts: list[Markup] = []
    for i, stage in enumerate(stages):
        x, hot = 60 + i * 175, where.stage == stage
        parts.append(
            tag(
                "rect",
                x=str(x),
                y="222",
                width="130",
                height="44",
                rx="6",
                fill="var(--warning)" if hot else "var(--shade)",
                stroke="var(--soft)",
            )
        )
        colour = "var(--paper)" if hot else "var(--ink)"
        parts.append(tag("text", stage, x=str(x + 65), y="249", text_anchor="middle", fill=colour, font_size="15"))
        if i < len(stages) - 1:
            parts.append(_line(x + 132, 244, x + 173, 244, "soft"))
    return parts


def pair_bars(before: dict[str, float], after: dict[str, float]) -> Markup:
    """Two bars a channel on a logarithmic scale that begins at one."""
    names = list(before)
    top = max([*before.values(), 10.0])
    scale = 480 / math.log10(top)
    parts: list[Markup] = []
    for i, name in enumerate(names):
        y = 20 + 34 * i
        parts.append(_text(78, y + 16, name, "end"))
        for value, colour, offset in ((before[name], "soft", 0), (after.get(name, 1.0), "second", 12)):
            width = max(1.5, scale * math.log10(max(value, 1.0)))
            parts.append(
                tag("rect", x="90", y=str(y + offset), width=f"{width:.1f}", height="10", fill=f"var(--{colour})")
            )
            parts.append(_text(96 + width, y + offset + 9, f"{value:.3g}", "start", size=11))
    parts.append(_text(90, 14, "grey: without the effect; green: with it", "start", size=12))
    return tag(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH} {30 + 34 * len(names)}",
        width="100%",
        role="img",
        aria_label="Residual of each channel before and after",
    )


def shrink_bar(shrink: Shrink) -> Markup:
    """The share of the gap that is closed, with its interval, beside the best rival's."""
    rows: list[tuple[str, float, tuple[float, float] | None, str]] = [
        ("this diagnosis", shrink.closed or 0.0, shrink.interval, "second"),
        *((f"best rival: {name.replace('_', ' ')}", value, None, "soft") for name, value in shrink.rival.items()),
    ]
    parts: list[Markup] = []
    for i, (name, value, interval, colour) in enumerate(rows):
        y = 30 + 62 * i
        parts.append(_text(40, y - 8, f"{name}: {value:.1%}", "start"))
        parts.append(tag("rect", x="40", y=str(y), width="640", height="20", fill="var(--shade)"))
        width = 640 * min(max(value, 0.0), 1.0)
        parts.append(tag("rect", x="40", y=str(y), width=f"{width:.1f}", height="20", fill=f"var(--{colour})"))
        if interval is not None:
            low, high = (40 + 640 * min(max(v, 0.0), 1.0) for v in interval)
            parts.append(_line(low, y + 10, high, y + 10, "ink"))
            parts += [_line(x, y + 4, x, y + 16, "ink") for x in (low, high)]
    return tag(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH} {20 + 62 * len(rows)}",
        width="100%",
        role="img",
        aria_label="Share of the gap that is closed",
    )


def budget_bars(budget: Budget) -> Markup:
    """A bar for each of the largest parts of the gap, to the left where it works against the others."""
    rows = budget.rows[:LONGEST]
    most = max([abs(r.share) for r in rows] or [1.0])
    colours = {"tolerance": "measured", "effect": "warning", "model": "model", "noise": "soft"}
    parts: list[Markup] = []
    for i, row in enumerate(rows):
        y, length = 10 + 26 * i, 280 * abs(row.share) / max(most, 1e-9)
        left = 400 - length if row.share < 0 else 400
        parts.append(_text(295, y + 14, row.said, "end", size=12))
        parts.append(_rect(left, y, max(length, 1.0), 18, colours[row.kind], False))
        parts.append(_text(690 if row.share >= 0 else 410, y + 14, f"{row.share:.1%}", "start", size=12))
    parts.append(_line(400, 4, 400, 10 + 26 * len(rows), "soft"))
    return tag(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH} {20 + 26 * len(rows)}",
        width="100%",
        role="img",
        aria_label="Share of the gap of each part",
    )


def _rect(x: float, y: float, width: float, height: float, colour: str, hot: bool) -> Markup:
    return tag(
        "rect",
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        width=f"{width:.1f}",
        height=f"{height:.1f}",
        rx="3",
        fill="var(--warning)" if hot else f"var(--{colour})",
    )


def _line(x1: float, y1: float, x2: float, y2: float, colour: str) -> Markup:
    return tag(
        "line",
        x1=f"{x1:.1f}",
        y1=f"{y1:.1f}",
        x2=f"{x2:.1f}",
        y2=f"{y2:.1f}",
        stroke=f"var(--{colour})",
        stroke_width="2",
    )


def _text(x: float, y: float, text: str, anchor: str, hot: bool = False, size: int = 13) -> Markup:
    return tag(
        "text",
        text,
        x=f"{x:.1f}",
        y=f"{y:.1f}",
        text_anchor=anchor,
        font_size=str(size),
        fill="var(--warning)" if hot else "var(--ink)",
        font_weight="600" if hot else "400",
    )
