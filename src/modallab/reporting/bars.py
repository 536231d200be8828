"""Horizontal bars as text and boxes of the page, legible at any width."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from modallab.reporting.markup import Markup, html_element


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
