"""The report: one HTML file that holds everything it shows."""

from dataclasses import replace
from pathlib import Path

from modallab.formats.atomic import write_text
from modallab.reporting.compare import modes
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, tag
from modallab.reporting.page_head import page_head
from modallab.reporting.sections import (
    assumptions,
    at_a_glance,
    half_power,
    model,
    provenance,
    rig,
    setups,
    shapes,
    signals,
    start,
    summary,
    verification,
)
from modallab.reporting.sections import modes as table_of_modes
from modallab.reporting.sections.section import Section


def write_report(path: Path, content: ReportContent) -> None:
    """Write the report. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = render(content)
    write_text(path, text)


def render(content: ReportContent) -> str:
    """The whole page as text."""
    found = modes(content.models, content.truth, content.confidence)
    parts = [
        table_of_modes.section(content, found),
        setups.section(content),
        shapes.section(content),
        verification.section(content),
        half_power.section(content, found),
        assumptions.section(content),
        *(
            replace(part, folded=True)
            for part in (
                start.section(content),
                signals.section(content),
                model.section(content),
                rig.section(content),
                provenance.section(content),
            )
        ),
    ]
    shown = [p for p in parts if p.body is not None]
    absent = _absent(parts)
    if absent is not None:
        shown.insert(len(shown) - 2, absent)
    head = tag(
        "header", tag("h1", content.title), tag("p", summary.sentence(content, found), class_="lead"),
        at_a_glance.glance(content, found), _contents(shown),
    )  # fmt: skip
    body = tag("body", head, tag("main", *(p.render() for p in shown)))
    return f'<!DOCTYPE html>\n<html lang="en">{page_head(content.title)}{body}</html>\n'


def _absent(parts: list[Section]) -> Section | None:
    reasons = list(dict.fromkeys(reason for p in parts for reason in p.absent if reason))
    if not reasons:
        return None
    return Section("absent", "What is not here, and why", tag("ul", *(tag("li", r) for r in reasons)))


def _contents(shown: list[Section]) -> Markup:
    return tag("nav", *(tag("a", p.heading, href=f"#{p.target}") for p in shown), aria_label="Contents")
