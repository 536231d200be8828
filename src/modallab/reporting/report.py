"""The report: one HTML file that holds everything it shows."""

from dataclasses import replace
from pathlib import Path

from modallab.formats.atomic import write_text
from modallab.reporting.compare import matched_modes
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, html_element, page_head
from modallab.reporting.sections import (
    half_power,
    model,
    overview,
    rig,
    setups,
    shapes,
    signals,
    start,
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
    found = matched_modes(content.models, content.truth, content.confidence)
    parts = [
        table_of_modes.modes_section(content, found),
        setups.setups_section(content),
        shapes.shapes_section(content),
        verification.verification_section(content),
        half_power.half_power_section(content, found),
        verification.assumptions_section(content),
        *(
            replace(part, folded=True)
            for part in (
                start.stabilisation_section(content),
                signals.signals_section(content),
                model.model_section(content),
                rig.rig_section(content),
                rig.provenance_section(content),
            )
        ),
    ]
    shown = [p for p in parts if p.body is not None]
    absent = _absent_parts(parts)
    if absent is not None:
        shown.insert(len(shown) - 2, absent)
    head = html_element(
        "header",
        html_element("h1", content.title),
        html_element("p", overview.summary_sentence(content, found), class_="lead"),
        overview.overview_list(content, found), _table_of_contents(shown),
    )  # fmt: skip
    body = html_element("body", head, html_element("main", *(p.render() for p in shown)))
    return f'<!DOCTYPE html>\n<html lang="en">{page_head(content.title)}{body}</html>\n'


def _absent_parts(parts: list[Section]) -> Section | None:
    reasons = list(dict.fromkeys(reason for p in parts for reason in p.absent if reason))
    if not reasons:
        return None
    return Section("absent", "What is not here, and why", html_element("ul", *(html_element("li", r) for r in reasons)))


def _table_of_contents(shown: list[Section]) -> Markup:
    return html_element(
        "nav", *(html_element("a", p.heading, href=f"#{p.target}") for p in shown), aria_label="Contents"
    )
