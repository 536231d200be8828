"""What it takes to repeat this."""

from modallab.core.block import Campaign
from modallab.core.digits import UNKNOWN, list_in_words
from modallab.core.units import Test
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import html_element, html_table, join_markup
from modallab.reporting.sections.section import Section

LONG = 120
"""A longer value is folded away."""


def provenance_section(content: ReportContent) -> Section:
    """Code version, seeds, hashes, rates, and the notes."""
    facts = content.provenance | content.campaign.provenance | _rates_in_words(content.campaign)
    if content.campaign.source:
        facts = {"campaign": content.campaign.source} | facts
    if content.truth is not None and content.truth.source:
        facts |= {"the truth is known from": content.truth.source}
    notes = html_element("ul", *(html_element("li", n) for n in content.notes)) if content.notes else None
    rows = [(what, _value_text(text)) for what, text in facts.items()]
    listing = html_table("Provenance", ("what", "value"), rows, class_="facts") if facts else None
    return Section("provenance", "Notes and provenance", join_markup([notes, listing]))


def _value_text(text: str) -> str:
    if len(text) <= LONG:
        return text
    return html_element("details", html_element("summary", f"{text[: LONG // 2]}…"), html_element("p", text))


def _rates_in_words(campaign: Campaign) -> dict[str, str]:
    facts: dict[str, str] = {}
    tests: tuple[Test, ...] = ("impact", "sine")
    for test in tests:
        blocks = campaign.of(test)
        if not blocks:
            continue
        facts[f"rates, {test} test"] = (
            f"requested {_range_of_values([b.requested_rate_hz for b in blocks])}, actual "
            f"{_range_of_values([b.actual_rate_hz for b in blocks])}, delivered "
            f"{_range_of_values([b.rate_hz for b in blocks])}"
        )
    return facts


def _range_of_values(values: list[float | None]) -> str:
    known = sorted({v for v in values if v is not None})
    return f"{list_in_words([f'{v:.10g}' for v in known])} Hz" if known else UNKNOWN
