"""HTML from Python. Every string is escaped unless it is markup that this module made."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

from modallab.reporting.figures import style

VOID = frozenset({"br", "hr", "input", "meta"})


class Markup(str):
    """Text that is markup already. Only `html_element`, `join_markup` and `trusted_markup` make it."""

    __slots__ = ()


def trusted_markup(text: str) -> Markup:
    """Markup of the project's own making, such as a drawn figure; never anything read from a file."""
    return Markup(text)


def join_markup(parts: Iterable[str | None]) -> Markup:
    """The parts one after the other, each escaped unless it is markup; None is left out."""
    return Markup("".join(_escape(part) for part in parts if part is not None))


def html_element(name: str, /, *children: str | None, **attributes: str | bool) -> Markup:
    """An element. `class_` and `for_` lose their underscore, other underscores become hyphens.

    An attribute that is True stands without a value, one that is False is left out.
    """
    head = "".join(_attribute(key, value) for key, value in attributes.items())
    if name in VOID:
        return Markup(f"<{name}{head}>")
    return Markup(f"<{name}{head}>{join_markup(children)}</{name}>")


def html_table(
    caption: str, header: Iterable[str], rows: Iterable[Iterable[str]], numeric: Iterable[int] = (), class_: str = ""
) -> Markup:
    """A table whose columns and rows have headers; the first cell of each row is its header.

    Args:
        caption: what the table holds.
        header: column headings.
        rows: cells.
        numeric: columns set to the right, in figures of equal width.
        class_: for the style sheet.
    """
    right, heads = frozenset(numeric), list(header)
    style = ["num" if i in right else "" for i in range(len(heads))]
    head = html_element("tr", *(html_element("th", text, scope="col", class_=style[i]) for i, text in enumerate(heads)))
    body = [html_element("tr", *(_table_cell(i, text, style[i]) for i, text in enumerate(row))) for row in rows]
    whole = html_element(
        "table",
        html_element("caption", caption),
        html_element("thead", head),
        html_element("tbody", *body),
        class_=class_,
    )
    # A wide table scrolls in its own frame, reachable by keyboard, so that the page never does.
    return html_element("div", whole, class_="scroll", tabindex="0", role="region", aria_label=str(caption))


def _table_cell(place: int, text: str, style: str) -> Markup:
    return html_element("th", text, scope="row", class_=style) if place == 0 else html_element("td", text, class_=style)


def _escape(text: str) -> str:
    return text if isinstance(text, Markup) else escape(text, quote=True)


def _attribute(key: str, value: str | bool) -> str:
    name = key.rstrip("_").replace("_", "-")
    if value is True:
        return f" {name}"
    if value is False or value == "":
        return ""
    return f' {name}="{escape(value, quote=True)}"'


def page_head(title: str) -> Markup:
    """The head of a page in the report's own dress, with its style sheet inside."""
    sheet = files("modallab.reporting").joinpath("report.css").read_text(encoding="utf-8")
    return html_element(
        "head",
        html_element("meta", charset="utf-8"),
        html_element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        html_element("meta", name="color-scheme", content="light dark"),
        html_element("title", title),
        html_element("style", trusted_markup(_colours_css() + sheet)),
    )


def _colours_css() -> str:
    light, dark = ("".join(f"--{name}:{pair[i]};" for name, pair in style.COLOURS.items()) for i in (0, 1))
    return f":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"


@dataclass(frozen=True, slots=True)
class Bar:
    """A bar of a figure.

    Attributes:
        label: what it is of.
        value: its length, to the left of zero where it is negative.
        said: the value in words.
        colour: name of a colour of the page.
        whisker: (low, high) of an interval.
    """

    label: str
    value: float
    shown: str
    colour: str
    whisker: tuple[float, float] | None = None


def scaled_bars(rows: Sequence[Bar], alt: str, least: float = 0.0) -> Markup:
    """The bars on one linear scale, from the most negative value, or zero, to the largest, or `least`."""
    values = [v for row in rows for v in (row.value, *(row.whisker or ()))]
    low, high = min([*values, 0.0]), max([*values, least, 1e-9])

    def at(value: float) -> float:
        return 100 * (value - low) / (high - low)

    return html_element("ul", *(_scaled_bar(row, at(0.0), at) for row in rows), class_="bars", aria_label=alt)


def _scaled_bar(row: Bar, zero: float, at: Callable[[float], float]) -> Markup:
    end = at(row.value)
    parts = [_bar_box(min(zero, end), abs(end - zero), f"background:var(--{row.colour})")]
    if row.whisker is not None:
        low, high = (at(v) for v in row.whisker)
        parts.append(_bar_box(low, max(high - low, 0.2), "top:40%;bottom:40%;background:var(--ink)"))
    track = html_element("span", *parts, class_="track", aria_hidden="true")
    return html_element("li", html_element("span", row.label), track, html_element("b", row.shown))


def _bar_box(left: float, width: float, more: str) -> Markup:
    return html_element("i", style=f"left:{left:.2f}%;width:{max(width, 0.15):.2f}%;{more}")
