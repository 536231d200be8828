"""What a section of the report is, and its common parts."""

from dataclasses import dataclass

from matplotlib.figure import Figure

from modallab.reporting.digits import glued
from modallab.reporting.figures.svg import panels
from modallab.reporting.markup import Markup, tag


@dataclass(frozen=True, slots=True)
class Section:
    """One part of the report.

    Attributes:
        anchor: its name in links.
        heading: its title.
        body: what it says; None leaves it out.
        absent: a sentence for each thing it could not show, and why.
    """

    anchor: str
    heading: str
    body: Markup | None
    absent: tuple[str, ...] = ()

    def render(self) -> Markup:
        """The section as HTML."""
        return tag("section", tag("h2", self.heading), self.body, id=self.anchor)


def plate(figure: Figure, name: str, alt: str, caption: str, columns: int = 2) -> Markup:
    """A figure with its caption.

    Args:
        figure: made by `style.grid`.
        name: unique on the page.
        alt: what is to be seen, for those who can't.
        caption: what it shows and how to read it.
        columns: panels a row on a wide page.
    """
    return tag("figure", panels(figure, name, alt, columns), tag("figcaption", glued(caption)), class_="plate")


def paragraph(text: str) -> Markup:
    """Plain text."""
    return tag("p", glued(text))
