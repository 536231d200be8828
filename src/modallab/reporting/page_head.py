"""The head of every page: the report's own dress, with its style sheet inside."""

from importlib.resources import files

from modallab.reporting.figures import style
from modallab.reporting.markup import Markup, html_element, trusted_markup


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
