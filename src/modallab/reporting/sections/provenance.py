"""What it takes to repeat this."""

from modallab.core.block import Campaign
from modallab.core.digits import UNKNOWN, listed
from modallab.core.units import Test
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import join, table, tag
from modallab.reporting.sections.section import Section

LONG = 120
"""A longer value is folded away."""


def section(content: ReportContent) -> Section:
    """Code version, seeds, hashes, rates, and the notes."""
    facts = content.provenance | content.campaign.provenance | _rates(content.campaign)
    if content.campaign.source:
        facts = {"campaign": content.campaign.source} | facts
    if content.truth is not None and content.truth.source:
        facts |= {"the truth is known from": content.truth.source}
    notes = tag("ul", *(tag("li", n) for n in content.notes)) if content.notes else None
    rows = [(what, _value(text)) for what, text in facts.items()]
    listing = table("Provenance", ("what", "value"), rows, class_="facts") if facts else None
    return Section("provenance", "Notes and provenance", join([notes, listing]))


def _value(text: str) -> str:
    if len(text) <= LONG:
        return text
    return tag("details", tag("summary", f"{text[: LONG // 2]}…"), tag("p", text))


def _rates(campaign: Campaign) -> dict[str, str]:
    facts: dict[str, str] = {}
    tests: tuple[Test, ...] = ("impact", "sine")
    for test in tests:
        blocks = campaign.of(test)
        if not blocks:
            continue
        facts[f"rates, {test} test"] = (
            f"requested {_spread([b.requested_rate_hz for b in blocks])}, actual "
            f"{_spread([b.actual_rate_hz for b in blocks])}, delivered {_spread([b.rate_hz for b in blocks])}"
        )
    return facts


def _spread(values: list[float | None]) -> str:
    known = sorted({v for v in values if v is not None})
    return f"{listed([f'{v:.10g}' for v in known])} Hz" if known else UNKNOWN
