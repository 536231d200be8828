"""Shapes of any structure that move: its lines in parallel projection, one small SVG a mode."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.core.digits import significant_digits, with_nonbreaking_spaces
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.deflection import motion_at_points, rotate_to_real, shapes_at_freedoms
from modallab.reporting.markup import Markup, html_element, trusted_markup

_WIDTH, _HEIGHT, _EDGE = 300.0, 200.0, 34.0
_PERIOD_S = 2.0
_REACH = 0.12
"""Share of the structure's size that the largest motion is drawn with."""
_TURN, _TILT = np.radians(35.0), np.radians(25.0)
MOST_LINES = 3000
"""Of one picture: a mesh with more of them is thinned out."""


@dataclass(frozen=True, eq=False, slots=True)
class MovingShape:
    """One mode at the places of a structure.

    Attributes:
        name: caption.
        frequency_hz: natural frequency.
        motion: (places, 3) complex, along x, y, z.
    """

    name: str
    frequency_hz: float
    motion: Complex128


def is_spatial(rig: Rig) -> bool:
    """Whether a rig says more of the places than a distance along a beam."""
    return bool(rig.lines) or bool(rig.surfaces) or any(p.y_m or p.z_m for p in rig.points)


def shapes_of_model(model: ModalModel, rig: Rig) -> list[MovingShape]:
    """A model's shapes, or operating shapes, at the points of its rig; [] if it has none.

    What several sensors at a point say is put together; a point that was neither measured nor driven stays at rest.
    """
    found = shapes_at_freedoms(model, rig)
    if found is None or not rig.points:
        return []
    return [
        MovingShape(f"Mode {r + 1}", float(hz), motion_at_points(rig, found[0], values))
        for r, (hz, values) in enumerate(zip(model.frequency_hz, found[1], strict=True))
    ]


def moving_wireframes(
    points: Mapping[int, tuple[float, float, float]],
    lines: Sequence[tuple[int, int]],
    shapes: Sequence[MovingShape],
    surfaces: Sequence[Sequence[int]] = (),
) -> Markup | None:
    """All shapes on one structure, moving, with a button to stop them; None if there is nothing to draw.

    Args:
        points: id -> x, y, z in m.
        lines: pairs of ids.
        shapes: with motions in the order of `points`.
        surfaces: ids around each face.
    """
    if len(points) < 2 or not shapes:
        return None
    xyz = np.array(list(points.values()), np.float64)
    order = {n: i for i, n in enumerate(points)}
    step = max(1, len(lines) // MOST_LINES)
    pairs = [(order[a], order[b]) for a, b in lines[::step] if a in order and b in order]
    few = surfaces[:: max(1, len(surfaces) // MOST_LINES)]
    faces = [[order[n] for n in face] for face in few if all(n in order for n in face)]
    pictures = [_wireframe_picture(xyz, pairs, faces, shape) for shape in shapes]
    return moving_pictures(pictures, "wireframes", "wireframe.js")


def drawing_projection() -> Real:
    """(3, 2): x to the right and back, y back, z up."""
    c, s = np.cos(_TURN), np.sin(_TURN)
    return np.array([[c, s * np.sin(_TILT)], [-s, c * np.sin(_TILT)], [0.0, -np.cos(_TILT)]])


def _wireframe_picture(
    xyz: Real, pairs: Sequence[tuple[int, int]], faces: Sequence[Sequence[int]], shape: MovingShape
) -> Markup:
    flat = (xyz - xyz.mean(axis=0)) @ drawing_projection()
    size = float(np.ptp(xyz, axis=0).max()) or 1.0
    span = np.maximum(np.ptp(flat, axis=0), 1e-9)
    scale = min((_WIDTH - 2 * _EDGE) / span[0], (_HEIGHT - 2 * _EDGE) / span[1])
    middle = (flat.max(axis=0) + flat.min(axis=0)) / 2
    rest = (flat - middle) * scale + np.array([_WIDTH, _HEIGHT]) / 2
    motion = rotate_to_real(shape.motion.ravel()).reshape(shape.motion.shape)
    reach = float(np.abs(motion).max()) or 1.0
    most = min(_REACH * size * scale, _EDGE - 6)
    moved = motion @ drawing_projection() * (most / reach)
    data = np.column_stack([rest, moved.real, moved.imag]).round(1)
    at = data[:, :2] + data[:, 2:4]
    joined = "".join(f"M{at[a, 0]:.1f} {at[a, 1]:.1f}L{at[b, 0]:.1f} {at[b, 1]:.1f}" for a, b in pairs)
    still = "".join(f"M{rest[a, 0]:.1f} {rest[a, 1]:.1f}L{rest[b, 0]:.1f} {rest[b, 1]:.1f}" for a, b in pairs)
    dots = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in at)
    shaded = "".join("M" + "L".join(f"{at[n, 0]:.1f} {at[n, 1]:.1f}" for n in face) + "Z" for face in faces)
    name = f"{shape.name}, {significant_digits(shape.frequency_hz)} Hz"
    drawing = trusted_markup(
        f'<svg viewBox="0 0 {_WIDTH:.0f} {_HEIGHT:.0f}" role="img" data-period="{_PERIOD_S:g}" '
        f'data-points="{_json_numbers(data.tolist())}" data-lines="{_json_numbers([list(p) for p in pairs])}" '
        f'data-faces="{_json_numbers([list(f) for f in faces])}">'
        f"{html_element('title', f'{name}: the structure vibrates')}"
        f'<path class="faces" d="{shaded}"/>'
        f'<path class="rest" d="{still}"/><path class="beam" d="{joined}"/><path class="dots" d="{dots}"/></svg>'
    )
    return html_element("figure", drawing, html_element("figcaption", html_element("b", with_nonbreaking_spaces(name))))


def _json_numbers(values: object) -> str:
    return json.dumps(values, separators=(",", ":"))


def moving_pictures(pictures: list[Markup], class_: str, script: str) -> Markup:
    """Pictures in a box of a class, which a script of this package moves by `swing.js`."""
    folder = files("modallab.reporting")
    code = "".join(folder.joinpath(name).read_text(encoding="utf-8") for name in ("swing.js", script))
    button = html_element("button", "Hold still", type="button", hidden=True)
    box = html_element("div", button, html_element("div", *pictures, class_="beams"), class_=class_)
    return trusted_markup(box + html_element("script", trusted_markup(code)))
