"""The model compared with the measurement."""

from math import isfinite

import numpy as np

from modallab.core.digits import NONE, four_places, list_in_words, probability_text, significant_digits
from modallab.core.model import Verification
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.figures.mobility import frf_at_one_point, mobility_panels
from modallab.reporting.figures.mode_shapes import farthest_sensor, sensor_label
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, captioned_figure, paragraph
from modallab.verification.assessment import ModelAssessment


def verification_section(content: ReportContent) -> Section:
    """Measured against regenerated mobility at all points, then at the free end in full."""
    parts: list[Markup] = []
    absent: list[str] = []
    for i, outcome in enumerate(content.outcomes):
        if outcome.verification is None:
            if outcome.model is not None and outcome.model.operating_shapes is not None:
                absent.append(
                    f"The model of {_test_name(outcome)} was not compared with its measurement: without a force "
                    "there is no response to compute."
                )
            elif outcome.model is not None:
                absent.append(
                    f"The model of {_test_name(outcome)} was not compared with its measurement: no "
                    "verification was given."
                )
            continue
        parts += _verification_of_test(content, outcome, outcome.verification, i)
    if not parts:
        return Section("verification", "Does the model match the measurement?", None, tuple(absent))
    return Section(
        "verification",
        "Does the model match the measurement?",
        join_markup([paragraph(_METHOD), *parts]),
        tuple(absent),
    )


_METHOD = (
    "The response of the model to the measured force is cut into the same blocks, processed in the same way, "
    "and compared with the measurement. FRAC measures the agreement of two curves: 1 is perfect, 0 is none. The thin "
    "line is the mobility of the model itself, without a block: its peaks are higher and sharper than a block of "
    "this length can show."
)


SEVERAL = " The figure shows the drive point with the worst match; the table has the others."


def _verification_of_test(content: ReportContent, outcome: OutcomeOfTest, check: Verification, i: int) -> list[Markup]:
    test = outcome.test or "frf"
    known = np.nan_to_num(check.frac, nan=0.0)
    worst = int(np.argmin(np.median(known, axis=0)))
    drive = check.measured.input_points[worst]
    at = "" if drive is None else f", force at point {drive}"
    output = farthest_sensor(content.rig, check.measured.outputs)
    where = sensor_label(check.measured.outputs[output], check.measured.output_points[output])
    named = where[0].lower() + where[1:]
    spread = f"FRAC is at least {four_places(known.min())}"
    alone = len(check.measured.outputs) == 1
    one = captioned_figure(
        frf_at_one_point(check, output, worst),
        f"one-{test}-{i}",
        f"Amplitude, phase, real and imaginary part of the mobility at {named}, measured and regenerated. {spread}",
        f"Mobility at {named}{at}, in full. {spread + '. ' if alone else ''}In the real and the imaginary part the "
        "peaks of the thin line are clipped.",
    )
    heading = html_element("h3", f"{_test_name(outcome)[0].upper()}{_name_of_test(outcome)[1:]}")
    if alone:
        return [heading, one]
    several = SEVERAL if check.frac.shape[1] > 1 else ""
    every = captioned_figure(
        mobility_panels(check, worst),
        f"all-{test}-{i}",
        f"Measured and regenerated mobility at {len(check.measured.outputs)} points over frequency, {spread}",
        f"Mobility at all points{at}: measured against regenerated. {spread}.{several}",
        min(3, len(check.measured.outputs)),
    )
    return [heading, every, one, _fracs_table(check)]


def _fracs_table(check: Verification) -> Markup:
    drives = [f"force at point {p}" if p is not None else "force" for p in check.measured.input_points]
    rows = [
        (sensor_label(name, point), *(four_places(float(value)) for value in check.frac[i]))
        for i, (name, point) in enumerate(zip(check.measured.outputs, check.measured.output_points, strict=True))
    ]
    points = [str(p) for p in check.measured.input_points if p is not None]
    driven = f", force at {'point' if len(points) == 1 else 'points'} {list_in_words(points)}" if points else ""
    whole = html_table(
        "FRAC of measured against regenerated mobility", ("response", *drives), rows, range(1, len(drives) + 1)
    )
    return html_element("details", html_element("summary", f"FRAC at every point{driven}"), whole)


def _test_name(outcome: OutcomeOfTest) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"


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
