"""A matplotlib figure as part of a page: one SVG a panel, in the page's own font and colours."""

import io
import re
from collections.abc import Callable
from html import escape
from typing import Any
from xml.etree import ElementTree as ET

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from modallab.reporting.figures import style
from modallab.reporting.markup import Markup, html_element, trusted_markup

_METADATA: dict[str, Any] = dict.fromkeys(("Date", "Creator", "Format", "Type"))
_TO_NAME = {light: f"var(--{name})" for name, (light, _) in style.COLOURS.items()}
_FINER = re.compile(r"(\d\.\d\d)\d+")
# What a page does without: blanks, namespaces, the drawing's own font and colours.
_LEAN: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]], ...] = (
    (re.compile(r"<!DOCTYPE[^>]*>", re.DOTALL), ""),
    (re.compile(r'\sxmlns(:\w+)?="[^"]*"'), ""),
    (re.compile(r"xlink:href"), "href"),
    (re.compile(r"\s+"), " "),
    (re.compile(r' transform="rotate\(-0 [^)]*\)"'), ""),
    (re.compile(r" ?font-family: [^;]*'DejaVu Sans'[^;\"]*;?"), ""),
    (re.compile(r"#[0-9a-f]{6}\b"), lambda match: _TO_NAME.get(match[0], match[0])),
)


def svg_panels(figure: Figure, name: str, alt: str, columns: int) -> Markup:
    """The panels of a figure, one SVG each, which the page sets in rows as its width allows.

    Args:
        figure: made by `style.grid`.
        name: unique on the page.
        alt: what is to be seen, for those who can't.
        columns: panels a row on a wide page.
    """
    root = _draw_svg(figure, name)
    groups = {g.get("id"): g for g in root.iter("g") if g.get("id")}
    clips = [d for d in root.findall("defs") if d.find("style") is None]
    cells = [
        _cell_svg(groups[str(axes.get_gid())], clips if i == 0 else [], _box_of_panel(figure, axes))
        for i, axes in enumerate(figure.axes)
    ]
    return html_element(
        "div",
        html_legend(figure),
        html_element("div", *cells, class_=f"panels of{columns}"),
        role="img",
        aria_label=alt,
    )


def html_legend(figure: Figure) -> Markup | None:
    """The figure's legend as text, with a small sample of each line; None if it has none."""
    if not figure.legends:
        return None
    entry = figure.legends[0]
    names = [text.get_text() for text in entry.get_texts()]
    pairs = zip(entry.legend_handles, names, strict=True)
    return html_element(
        "p", *(html_element("span", _legend_sample(handle), name) for handle, name in pairs), class_="key"
    )


def _draw_svg(figure: Figure, name: str) -> ET.Element:
    for i, axes in enumerate(figure.axes):
        axes.set_gid(f"{name}-{i}")
    stream = io.StringIO()
    # The salt makes the names of markers and clips unique on the page, and the same in every run.
    with style.figure_style(), mpl.rc_context({"svg.hashsalt": name}):
        figure.savefig(stream, format="svg", metadata=_METADATA)
    text = stream.getvalue()
    for pattern, replacement in _LEAN:
        text = pattern.sub(replacement, text)
    root = ET.fromstring(text)
    for element in root.iter():
        for key in ("d", "x", "y", "transform"):
            if key in element.attrib:
                # A hundredth of a px is finer than any screen.
                element.attrib[key] = _FINER.sub(r"\1", element.attrib[key])
    return root


def _box_of_panel(figure: Figure, axes: Axes) -> tuple[float, float, float, float]:
    """Left, top, width and height of a panel's cell in the drawing."""
    width, height = (float(v) * style.PX_PER_INCH for v in figure.get_size_inches())
    inner = axes.get_position()
    return (
        inner.x0 * width - style.LEFT,
        (1 - inner.y1) * height - style.TOP,
        inner.width * width + style.LEFT + style.RIGHT,
        inner.height * height + style.TOP + style.BOTTOM,
    )


def _cell_svg(group: ET.Element, shared: list[ET.Element], box: tuple[float, float, float, float]) -> Markup:
    for element in group.iter("g"):
        element.attrib.pop("id", None)
    inner = "".join(ET.tostring(e, encoding="unicode") for e in (*shared, group))
    view = " ".join(f"{v:.0f}" for v in box)
    return trusted_markup(f'<svg viewBox="{view}" aria-hidden="true">{inner}</svg>')


def _legend_sample(handle: Any) -> Markup:
    """A legend's line, marker or patch, drawn small."""
    if hasattr(handle, "get_facecolor"):
        fill = _colour(handle.get_facecolor())
        return _swatch_svg(f'<rect x="4" y="1" width="20" height="10" fill="{fill}" opacity="{_opacity(handle)}"/>')
    return _swatch_svg(_stroke_style(handle) + _marker(handle))


def _swatch_svg(inner: str) -> Markup:
    return trusted_markup(f'<svg viewBox="0 0 28 12" width="28" height="12" aria-hidden="true">{inner}</svg>')


def _stroke_style(line: Any) -> str:
    dashes = {"--": "5 3", ":": "1.5 2.5", "-.": "6 2 1.5 2"}.get(line.get_linestyle(), "")
    if line.get_linestyle() in ("None", "none", "", " "):
        return ""
    return (
        f'<path d="M1 6H27" fill="none" stroke="{_colour(line.get_color())}" '
        f'stroke-width="{line.get_linewidth():g}" stroke-dasharray="{dashes}" opacity="{_opacity(line)}"/>'
    )


def _marker(line: Any) -> str:
    edge, fill = _colour(line.get_markeredgecolor()), _colour(line.get_markerfacecolor())
    paint = f'stroke="{edge}" fill="{fill}" stroke-width="1.4"'
    shapes = {
        "o": f'<circle cx="14" cy="6" r="3.6" {paint}/>',
        "s": f'<rect x="10.6" y="2.6" width="6.8" height="6.8" {paint}/>',
        "D": f'<path d="M14 1.6L18.4 6L14 10.4L9.6 6Z" {paint}/>',
        "^": f'<path d="M14 2L18 9.6H10Z" {paint}/>',
        "v": f'<path d="M14 10L18 2.4H10Z" {paint}/>',
        "|": f'<path d="M14 1V11" stroke="{edge}" stroke-width="2"/>',
        "x": f'<path d="M11 3L17 9M11 9L17 3" stroke="{edge}" stroke-width="1.6"/>',
    }
    return shapes.get(str(line.get_marker()), "")


def _opacity(handle: Any) -> float:
    alpha = handle.get_alpha()
    return 1.0 if alpha is None else float(alpha)


def _colour(value: Any) -> str:
    if isinstance(value, str) and value == "none":
        return "none"
    light = to_hex(value)
    return escape(_TO_NAME.get(light, light))
