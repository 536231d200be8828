"""What the model rests on, as verdicts with numbers, and how well each mode stands."""

from math import isfinite

import numpy as np

from modallab.core.digits import NONE, probability_text, significant_digits
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, paragraph
from modallab.verification.assessment import ModelAssessment

HEADING = "What the model assumes, and whether it holds"


def assumptions_section(content: ReportContent) -> Section:
    """One table of verdicts and one of modes a test."""
    parts: list[Markup] = []
    absent: list[str] = []
    for outcome in content.outcomes:
        if outcome.assessment is not None and outcome.model is not None:
            parts += _assumptions_of_test(outcome, outcome.assessment)
            absent += [
                f"{_name_of_test(outcome)}: {name} was not judged: {_first_sentence(why)}."
                for name, why in _reasons_list(outcome)
            ]
    if not parts:
        return Section("assumptions", HEADING, None, tuple(absent))
    lead = paragraph(
        "A modal model assumes a structure that is linear, reciprocal and constant from the first record to the "
        "last. Real shapes also assume proportional damping. Each assumption is tested on the records."
    )
    return Section("assumptions", HEADING, join_markup([lead, *parts]), tuple(absent))


def _reasons_list(outcome: OutcomeOfTest) -> tuple[tuple[str, str], ...]:
    return () if outcome.assessment is None else outcome.assessment.unjudged


def _first_sentence(text: str) -> str:
    return text.splitlines()[0]


def _assumptions_of_test(outcome: OutcomeOfTest, found: ModelAssessment) -> list[Markup]:
    verdicts = [(v.assumption, "holds" if v.holds else "does not hold", v.words) for v in found.verdicts]
    parts: list[Markup] = [html_element("h3", _name_of_test(outcome))]
    if verdicts:
        parts.append(html_table("Assumptions", ("assumption", "verdict", "because"), verdicts, ()))
    parts.append(_modes_table(outcome, found))
    if len(found.auto_mac) > 1 and np.isfinite(found.auto_mac).all():
        parts.append(_auto_mac(outcome, found))
    return parts


def _auto_mac(outcome: OutcomeOfTest, found: ModelAssessment) -> Markup:
    """Modes with a high value off the diagonal cannot be distinguished with these points."""
    names = [f"mode {r + 1}" for r in range(len(found.auto_mac))]
    rows = [(name, *(_number(float(value)) for value in row)) for name, row in zip(names, found.auto_mac, strict=True)]
    whole = html_table("AutoMAC: MAC of the shapes with one another", ("", *names), rows, range(1, len(names) + 1))
    return html_element(
        "details",
        html_element("summary", f"AutoMAC, {_name_of_test(outcome)[0].lower()}{_name_of_test(outcome)[1:]}"),
        whole,
    )


def _modes_table(outcome: OutcomeOfTest, found: ModelAssessment) -> Markup:
    assert outcome.model is not None
    others = found.auto_mac - np.eye(len(found.auto_mac))
    rows = [
        (
            str(r + 1),
            significant_digits(float(f), 4),
            probability_text(found.confidence[r]),
            _number(found.mpc[r]),
            f"{np.degrees(found.mpd_rad[r]):.3f}",
            _number(others[r].max()) if len(others) > 1 else NONE,
        )
        for r, f in enumerate(outcome.model.frequency_hz)
    ]
    header = ("mode", "frequency [Hz]", "confidence", "MPC", "MPD [°]", "largest MAC with another mode")
    return html_table(
        "Modes: 1 is the best confidence and the best phase collinearity", header, rows, range(1, len(header))
    )


def _number(value: float) -> str:
    return significant_digits(float(value), 3) if isfinite(value) else "not known"


def _name_of_test(outcome: OutcomeOfTest) -> str:
    return f"The {outcome.test} test" if outcome.test else "The FRFs"
