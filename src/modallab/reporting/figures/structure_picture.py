"""A structure in parallel projection with the place of a change marked, as SVG in the colours of the page."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.rig import Rig
from modallab.reporting.figures.wireframe import drawing_projection
from modallab.reporting.markup import Markup, html_element

WIDTH, HEIGHT, EDGE = 420.0, 280.0, 40.0
"""Of the drawing's own units: about a phone's, so that its text is legible there."""
NUMBERED = 60
"""Points up to which each that has room has its number beside it."""
APART = 16.0
"""Room that a number asks for."""
AXIS = 24.0
"""Length of the arrows that say where x, y and z go."""


@dataclass(frozen=True, eq=False, slots=True)
class MarkedPlaces:
    """What is marked.

    Attributes:
        at_m: (places, 3) where.
        towards_m: (3,) to where from the first of them; None: nowhere.
        said: beside it.
    """

    at_m: Real
    towards_m: Real | None = None
    label: str = ""


def structure_picture(rig: Rig, marked: MarkedPlaces | None) -> Markup:
    """Points, lines and faces of the rig, sensors filled, what is marked in the warning's colour."""
    xyz = np.array([(p.x_m, p.y_m, p.z_m) for p in rig.points])
    more = np.zeros((0, 3)) if marked is None else marked.at_m
    if marked is not None and marked.towards_m is not None:
        more = np.concatenate([more, marked.towards_m[None]])
    flat, added = np.split(_place_on_drawing(np.concatenate([xyz, more]), len(xyz)), [len(xyz)])
    order = {p.id: n for n, p in enumerate(rig.points)}
    parts = [
        html_element("path", d=_draw_faces(rig, order, flat), fill="var(--measured)", fill_opacity="0.12"),
        html_element("path", d=_draw_lines(rig, order, flat), fill="none", stroke="var(--soft)", stroke_width="1.2"),
        *_draw_points(rig, order, flat),
        *(_draw_marks(added, marked) if marked is not None else []),
        *_draw_axes(),
    ]
    return html_element(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH:.0f} {HEIGHT:.0f}",
        width="100%",
        role="img",
        aria_label="The structure with the place marked" if marked is not None else "The structure",
    )


def _place_on_drawing(xyz_m: Real, of: int) -> Real:
    """(places, 2) on the drawing, scaled so that the first `of` fill it."""
    flat = xyz_m @ drawing_projection()
    low, high = flat[:of].min(axis=0), flat[:of].max(axis=0)
    room = np.array([WIDTH, HEIGHT]) - 2 * EDGE
    scale = float(np.min(room / np.maximum(high - low, 1e-9)))
    return (flat - (low + high) / 2) * scale + np.array([WIDTH, HEIGHT]) / 2


def _draw_faces(rig: Rig, order: dict[int, int], at: Real) -> str:
    known = [face for face in rig.surfaces if all(p in order for p in face)]
    return "".join("M" + "L".join(_coordinates_text(at[order[p]]) for p in face) + "Z" for face in known)


def _draw_lines(rig: Rig, order: dict[int, int], at: Real) -> str:
    return "".join(
        f"M{_coordinates_text(at[order[a]])}L{_coordinates_text(at[order[b]])}"
        for a, b in rig.lines
        if a in order and b in order
    )


def _draw_points(rig: Rig, order: dict[int, int], at: Real) -> list[Markup]:
    sensed = {c.point for c in rig.responses}
    parts = [
        html_element(
            "circle",
            cx=f"{at[n, 0]:.1f}",
            cy=f"{at[n, 1]:.1f}",
            r="3.5",
            fill="var(--ink)" if p in sensed else "var(--paper)",
            stroke="var(--ink)",
        )
        for p, n in order.items()
    ]
    # Below the point and beyond a ring about it: a mark's line leads up.
    below = np.array([4.0, 19.0])
    return [*parts, *(_draw_text(at[order[p]] + below, str(p), "var(--soft)") for p in _points_with_room(order, at))]


def _points_with_room(order: dict[int, int], at: Real) -> list[int]:
    """Points whose numbers have room."""
    if len(order) > NUMBERED:
        return []
    kept: list[int] = []
    for p, n in order.items():
        if all(np.linalg.norm(at[order[k]] - at[n]) > APART for k in kept):
            kept.append(p)
    return kept


def _draw_marks(at: Real, marked: MarkedPlaces) -> list[Markup]:
    n = len(marked.at_m)
    parts = [
        html_element(
            "circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r="11", fill="none", stroke="var(--warning)", stroke_width="2.5"
        )
        for x, y in at[:n]
    ]  # fmt: skip
    if marked.towards_m is not None:
        path = f"M{_coordinates_text(at[0])}L{_coordinates_text(at[n])}"
        parts.append(html_element("path", d=path, fill="none", stroke="var(--warning)", stroke_width="2.5"))
        parts.append(html_element("circle", cx=f"{at[n, 0]:.1f}", cy=f"{at[n, 1]:.1f}", r="4.5", fill="var(--warning)"))
    if marked.label and n:
        # Above all points, where nothing else is written.
        left = at[0, 0] > WIDTH / 2
        parts.append(html_element("path", d=f"M{at[0, 0]:.1f} {at[0, 1] - 11:.1f}V24", stroke="var(--warning)"))
        shift = np.array([-6.0 if left else 6.0, 28.0 - at[0, 1]])
        parts.append(_draw_text(at[0] + shift, marked.label, "var(--warning)", "end" if left else "start", "600"))
    return parts


def _draw_axes() -> list[Markup]:
    origin, parts = np.array([30.0, HEIGHT - 26.0]), []
    for name, arm in zip("xyz", drawing_projection(), strict=True):
        end = origin + AXIS * arm
        path = f"M{_coordinates_text(origin)}L{_coordinates_text(end)}"
        parts.append(html_element("path", d=path, fill="none", stroke="var(--soft)", stroke_width="1.2"))
        parts.append(_draw_text(origin + (AXIS + 8) * arm + [0, 4], name, "var(--soft)", "middle"))
    return parts


def _coordinates_text(at: Sequence[float] | Real) -> str:
    return f"{at[0]:.1f} {at[1]:.1f}"


def _draw_text(at: Real, text: str, colour: str, anchor: str = "start", weight: str = "400") -> Markup:
    size = "12" if weight == "600" else "10"
    return html_element(
        "text", text, x=f"{at[0]:.1f}", y=f"{at[1]:.1f}", fill=colour, text_anchor=anchor, font_size=size,
        font_weight=weight,
    )  # fmt: skip
