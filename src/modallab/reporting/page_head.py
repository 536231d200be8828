"""The head of every page: the report's own dress, with its style sheet inside."""

from importlib.resources import files

from modallab.reporting.figures import style
from modallab.reporting.markup import Markup, tag, trusted


def page_head(title: str) -> Markup:
    """The head of a page in the report's own dress, with its style sheet inside."""
    sheet = files("modallab.reporting").joinpath("report.css").read_text(encoding="utf-8")
    return tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("title", title),
        tag("style", trusted(_colours() + sheet)),
    )


def _colours() -> str:
    light, dark = ("".join(f"--{name}:{pair[i]};" for name, pair in style.COLOURS.items()) for i in (0, 1))
    return f":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}"
