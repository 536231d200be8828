"""What a diagnosis compared: explanations with what they leave, and the residual before and after."""

import re
from collections.abc import Sequence

from modallab.core.diagnosis import CandidateSet, Diagnosis, Shrinkage
from modallab.core.digits import probability_text, share_text, superscript_text, three_digits, with_nonbreaking_spaces
from modallab.gap.words.effects import effect_names
from modallab.reporting.figures import style
from modallab.reporting.figures.log_bars import BarRow, log_bars
from modallab.reporting.markup import Bar, Markup, html_element, html_table, page_head, scaled_bars
from modallab.reporting.sections.section import captioned_figure

_PERCENT = re.compile(r"(?<=\d)%")
_POWER = re.compile(r"(?<=[a-z])\^(-?\d)")
_MINUS = re.compile(r"(?<![\w\d])-(?=\d)")


def typeset_sentence(text: str) -> str:
    """A sentence of a diagnosis with a blank before `%`, raised powers of units and true minus signs."""
    text = _POWER.sub(lambda power: superscript_text(int(power[1])), text)
    return with_nonbreaking_spaces(_MINUS.sub("\u2212", _PERCENT.sub(" %", text)))


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


CLOSED = "Share of the gap that is closed"


def candidates_section(diagnosis: Diagnosis) -> Markup | None:
    """The gap that each explanation leaves, beside that without any; None where none was fitted."""
    if not diagnosis.candidates:
        return None
    rows = [BarRow("no effect", (diagnosis.gap.before,))]
    rows += [
        BarRow(
            effect_names(c.effects), (c.gap,), f", probability {probability_text(_stated_probability(c, diagnosis))}"
        )
        for c in diagnosis.candidates
    ]
    caption = "The gap that each fitted explanation leaves, beside the gap without any effect. 1 is noise alone."
    if diagnosis.unknown is not None:
        caption += f" An unnamed cause has a probability of {probability_text(diagnosis.unknown)}."
    figure = log_bars(rows, ("gap",), (style.MEASURED,), above=True)
    return page_section("The candidates", captioned_figure(figure, "candidates", caption, caption, columns=1))


def _stated_probability(candidate: CandidateSet, diagnosis: Diagnosis) -> float:
    """The probability of an explanation; where it is the one effect that was found, what is stated of that effect."""
    one = diagnosis.effects[0] if len(diagnosis.effects) == 1 else None
    return one.probability if one is not None and candidate.effects == [one.effect] else candidate.probability


def shrinkage_section(diagnosis: Diagnosis) -> Markup | None:
    """The share of the gap that effects close on held-out records, beside the best rival's; None without effects."""
    shrink = diagnosis.shrink
    if shrink.closed is None or diagnosis.verdict != "known":
        return None
    rows = [Bar("this diagnosis", shrink.closed, share_text(shrink.closed), "second", shrink.interval)]
    rows += [
        Bar(f"best other explanation: {effect_names(name.split('+'))}", closed, share_text(closed), "soft")
        for name, closed in shrink.rival.items()
    ]
    ends = [share_text(v) for v in shrink.interval or ()]
    # An interval that is narrower than the digits shown says nothing more.
    interval = f" (95 %: {' to '.join(ends)}, the dark line)" if len(set(ends)) > 1 else ""
    caption = (
        f"Share of the gap above noise that is closed on {len(shrink.held_out)} held-out records{interval}: "
        f"from {three_digits(shrink.before)} to {three_digits(shrink.after)} noise units."
    )
    return page_section("Shrinkage of the gap", captioned_picture(scaled_bars(rows, CLOSED, 1.0), caption))


def shrinkage_bar(name: str, shrink: Shrinkage) -> Markup:
    """One bar: the share of the gap that is closed on held-out records; empty where there was none to close."""
    closed = shrink.closed or 0.0
    return scaled_bars([Bar(name, closed, share_text(closed), "second", shrink.interval)], CLOSED, 1.0)


def channel_bars(before: dict[str, float], after: dict[str, float], name: str, caption: str) -> Markup:
    """Two bars a channel on a logarithmic axis: before and after."""
    rows = [BarRow(channel, (gap, after.get(channel))) for channel, gap in before.items()]
    figure = log_bars(rows, ("before", "after"), (style.SOFT, style.SECOND))
    return captioned_figure(figure, name, caption, caption, columns=1)


def residual_section(diagnosis: Diagnosis) -> Markup:
    """The gap by channel, before and after, and by band, test, level and time."""
    gap = diagnosis.gap
    caption = "The gap of each channel, before any effect and with the effects found. 1 is noise alone."
    bands = [[f"{k.replace('-', ' to ')} Hz", share_text(v)] for k, v in gap.by_band.items()]
    tests = [
        *([f"{k} test", three_digits(v)] for k, v in gap.by_test.items()),
        *([f"level {k}", three_digits(v)] for k, v in gap.by_level.items()),
        *([f"{k} of the time", three_digits(v)] for k, v in gap.by_order.items()),
    ]
    return page_section(
        "The residual, before and after",
        channel_bars(gap.by_channel, gap.after_by_channel, "channels", caption) if gap.by_channel else None,
        html_element(
            "div",
            html_table("Share of the squared gap by band, before", ["band", "share"], bands, numeric=(1,)),
            html_table("Gap by test, level and time, before", ["part", "noise units"], tests, numeric=(1,)),
            class_="pair",
        ),
    )
