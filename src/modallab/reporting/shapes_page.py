"""A page of moving shapes alone: what a file of results holds, without a test behind it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from modallab.formats.atomic import replacing
from modallab.reporting.figures.wireframe import MovingShape, moving_wireframes
from modallab.reporting.markup import html_element, page_head


def write_shapes_page(
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
        html_element("main", drawn or html_element("p", "There is no shape.")),
    )
    with replacing(path) as draft:
        text = f'<!DOCTYPE html>\n<html lang="en">{page_head(title)}{body}</html>\n'
        draft.write_text(text, encoding="utf-8", newline="\n")
