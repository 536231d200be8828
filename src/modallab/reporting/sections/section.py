"""What a section of the report is, and its common parts."""

from dataclasses import dataclass

from matplotlib.figure import Figure

from modallab.core.digits import with_nonbreaking_spaces
from modallab.reporting.figures.svg import svg_panels
from modallab.reporting.markup import Markup, html_element


@dataclass(frozen=True, slots=True)
class Section:
    """One part of the report.

    Attributes:
        anchor: its name in links.
        heading: its title.
        body: what it says; None leaves it out.
        absent: a sentence for each thing it could not show, and why.
        folded: whether it is shown, and printed, only once it is asked for: detail that most readers do not need.
    """

    anchor: str
    heading: str
    body: Markup | None
    absent: tuple[str, ...] = ()
    folded: bool = False

    @property
    def target(self) -> str:
        """What a link leads to: within what is folded, so that a browser unfolds it."""
        return f"{self.anchor}-unfolded" if self.folded else self.anchor

    def render(self) -> Markup:
        """The section as HTML."""
        heading = html_element("h2", self.heading)
        if not self.folded:
            return html_element("section", heading, self.body, id=self.anchor)
        inside = html_element("div", self.body, id=self.target)
        return html_element(
            "section",
            html_element("details", html_element("summary", heading), inside),
            id=self.anchor,
            class_="folded",
        )


def captioned_figure(figure: Figure, name: str, alt: str, caption: str, columns: int = 2) -> Markup:
    """A figure with its caption.

    Args:
        figure: made by `style.grid`.
        name: unique on the page.
        alt: what is to be seen, for those who can't.
        caption: what it shows and how to read it.
        columns: panels a row on a wide page.
    """
    return html_element(
        "figure",
        svg_panels(figure, name, alt, columns),
        html_element("figcaption", with_nonbreaking_spaces(caption)),
        class_="plate",
    )


def paragraph(text: str) -> Markup:
    """Plain text."""
    return html_element("p", with_nonbreaking_spaces(text))
