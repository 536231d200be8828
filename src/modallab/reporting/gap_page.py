"""The frame of a page about the gap: head, style and sections."""

import re
from collections.abc import Sequence

from modallab.core.digits import superscript_text, with_hard_blanks
from modallab.reporting.markup import Markup, html_element, page_head

_PERCENT = re.compile(r"(?<=\d)%")
_POWER = re.compile(r"(?<=[a-z])\^(-?\d)")
_MINUS = re.compile(r"(?<![\w\d])-(?=\d)")


def typeset_sentence(text: str) -> str:
    """A sentence of a diagnosis with a blank before `%`, raised powers of units and true minus signs."""
    text = _POWER.sub(lambda power: superscript_text(int(power[1])), text)
    return with_hard_blanks(_MINUS.sub("\u2212", _PERCENT.sub(" %", text)))


def whole_page(title: str, opening: str | Sequence[str], *sections: Markup | None) -> str:
    """A whole page as text, in the colours of light and dark screens.

    Args:
        title: heading.
        said: what is to be known first, a paragraph each; empty ones are left out.
        sections: in this order; None for one that there is not.
    """
    paragraphs = [opening] if isinstance(opening, str) else list(opening)
    lead = [
        html_element("p", paragraphs[0], class_="lead"),
        *(html_element("p", text) for text in paragraphs[1:] if text),
    ]
    body = html_element(
        "body", html_element("header", html_element("h1", title), *lead), html_element("main", *sections)
    )
    return f'<!DOCTYPE html>\n<html lang="en">{page_head(title)}{body}</html>\n'


def page_section(heading: str, *parts: str | None) -> Markup:
    """A section with its heading."""
    return html_element("section", html_element("h2", heading), *parts)


def captioned_picture(drawn: Markup, caption: str) -> Markup:
    """A picture with what it shows."""
    return html_element(
        "figure", html_element("div", drawn, class_="scroll"), html_element("figcaption", caption), class_="plate"
    )
