"""What a file with results but no measurement yields: its geometry and its shapes."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from modallab import __version__
from modallab.formats.atomic import replacing, write_text
from modallab.formats.format import sniff
from modallab.formats.uff.uff_functions import read_functions
from modallab.formats.uff.uff_results import NodeMode, Results, read_results
from modallab.reporting.figures.wireframe import MovingShape, moving_wireframes
from modallab.reporting.markup import html_element, page_head

_MEASURED = (1, 4)
"""Function types that a model can be identified from: time records and FRFs."""
MOST_SHAPES = 40
"""Shapes on one page."""


def holds_results_only(path: Path) -> bool:
    """Whether a universal file holds geometry or modes, and no time record or FRF.

    Raises:
        FormatError: no such file, or damaged.
    """
    if sniff(path).name != "uff":
        return False
    if any(f.kind in _MEASURED for f in read_functions(path).functions):
        return False
    found = read_results(path)
    return bool(found.geometry.points or found.modes)


def import_results(path: Path, out: Path) -> tuple[str, ...]:
    """Write the geometry and the shapes of a file as JSON, and a page that moves them; say what was written.

    Args:
        path: universal file.
        out: name for what is written, with the endings .json and .html.

    Raises:
        FormatError, StorageError: it cannot be read, or the files cannot be written.
    """
    found = read_results(path)
    write_text(out.with_suffix(".json"), json.dumps(results_document(found, path), allow_nan=False) + "\n")
    points, lines = found.geometry.points, found.geometry.lines
    report = [
        f"{path.name} holds no measurement: {len(points)} points, {len(lines)} lines and {len(found.modes)} modes",
        f"geometry and shapes: {out.with_suffix('.json')}",
    ]
    if found.forced:
        report.append(f"note: {found.forced} sets are deflections under a load, not modes, and are left out")
    moving = [_moving_shape(n, mode, found) for n, mode in enumerate(found.modes[:MOST_SHAPES], 1)]
    if moving and len(points) > 1:
        _write_shapes_page(out.with_suffix(".html"), path.stem, points, lines, moving, found.geometry.surfaces)
        report.append(f"shapes, moving: {out.with_suffix('.html')}")
    elif moving:
        report.append("note: the file has no places of nodes, so the shapes cannot be drawn")
    return tuple(report)


def results_document(found: Results, path: Path) -> dict[str, object]:
    """Geometry in m and modes as JSON values; shapes as [re, im] along x, y and z by node."""
    return {
        "format_version": 1,
        "code_version": __version__,
        "source": path.name,
        "points": [{"id": n, "x_m": x, "y_m": y, "z_m": z} for n, (x, y, z) in found.geometry.points.items()],
        "lines": [list(pair) for pair in found.geometry.lines],
        "surfaces": [list(face) for face in found.geometry.surfaces],
        "modes": [
            {
                "title": mode.title,
                "frequency_hz": mode.frequency_hz,
                "damping_ratio": mode.damping_ratio,
                "shape": {str(n): [[float(v.real), float(v.imag)] for v in at] for n, at in mode.at.items()},
            }
            for mode in found.modes
        ],
    }


def _moving_shape(n: int, mode: NodeMode, found: Results) -> MovingShape:
    rest = np.zeros(3, np.complex128)
    return MovingShape(
        f"Mode {n}", mode.frequency_hz, np.array([mode.at.get(node, rest) for node in found.geometry.points])
    )


def _write_shapes_page(
    path: Path,
    title: str,
    points: Mapping[int, tuple[float, float, float]],
    lines: Sequence[tuple[int, int]],
    shapes: Sequence[MovingShape],
    surfaces: Sequence[Sequence[int]] = (),
) -> None:
    """Write one HTML file that holds everything it shows.

    Args:
        path: of the file.
        title: heading.
        points: id -> x, y, z in m.
        lines: pairs of ids.
        shapes: with motions in the order of `points`.
        surfaces: ids around each face.

    Raises:
        StorageError: the file cannot be written.
    """
    drawn = moving_wireframes(points, lines, shapes, surfaces)
    summary = html_element("p", f"{len(points)} points, {len(lines)} lines, {len(shapes)} shapes.", class_="lead")
    body = html_element(
        "body",
        html_element("header", html_element("h1", title), summary),
        html_element("main", drawn or html_element("p", "The file has no shapes.")),
    )
    with replacing(path) as draft:
        text = f'<!DOCTYPE html>\n<html lang="en">{page_head(title)}{body}</html>\n'
        draft.write_text(text, encoding="utf-8", newline="\n")
