"""The table of modes, and whether the tests agree."""

from math import isfinite

from modallab.core.digits import (
    UNKNOWN,
    in_sigmas,
    list_in_words,
    probability_text,
    relative_change,
    relative_difference,
    rounded_to_sigma,
    significant_digits,
    with_nonbreaking_spaces,
    with_sigma,
)
from modallab.reporting.compare import ComparedMode, ModeReading, agreement_verdict, joint_deviations
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.overview import compare_tests
from modallab.reporting.sections.section import Section, paragraph

HEADER = ("mode", "test", "frequency [Hz]", "damping ζ [%]", "half-power ζ [%]")
TRUTH = ("true frequency [Hz], error", "true ζ [%], error")


def modes_section(content: ReportContent, modes: tuple[ComparedMode, ...]) -> Section:
    """Frequencies and damping with their sigmas, beside the half-power reading and the truth."""
    missing = tuple(o.missing for o in content.outcomes if o.model is None and o.missing)
    if not content.models:
        return Section("modes", "The modes", None, missing or ("There is no modal model: no test was identified.",))
    if not modes:
        return Section("modes", "The modes", paragraph(_no_model_sentence(content)), missing)
    parts: list[Markup | None] = [
        _modes_table(content, modes),
        paragraph(
            "The number after ± is one standard deviation, σ. The damping ratio ζ is the share of critical "
            "damping; the loss factor is η = 2ζ. The half-power reading is given as ζ too. Confidence compares the "
            "strength of a mode with that of noise and of the residual: 0 is at the limit, 1 far above."
        ),
        _drift_sentence(content),
        _understated_uncertainty(modes),
        _modes_not_found(content, modes),
        _notes_list(content),
        _agreement_sentence(modes),
    ]
    absent = missing + (
        () if content.truth else ("The true modes are not known; only a simulated bench can state them.",)
    )
    return Section("modes", "The modes", join_markup(parts), absent)


def _modes_not_found(content: ReportContent, modes: tuple[ComparedMode, ...]) -> Markup | None:
    """Modes that lie in the band of a test that did not find them."""
    lines: list[Markup] = []
    for model in content.models:
        low, high = model.band_hz
        inside = [m for m in modes if low <= m.frequency_hz <= high]
        lost = [f"mode {m.number}" for m in inside if all(r.test != model.test for r in m.readings)]
        if lost:
            name = f"The {model.test} test" if model.test else "The FRFs' model"
            lines.append(paragraph(f"{name} did not find {list_in_words(lost)}, although they are in its band."))
    return join_markup(lines) if lines else None


def _notes_list(content: ReportContent) -> Markup | None:
    notes = [f"{(m.test or 'FRFs').capitalize()}: {note}" for m in content.models for note in m.notes]
    return html_element("ul", *(html_element("li", with_nonbreaking_spaces(n)) for n in notes)) if notes else None


def _no_model_sentence(content: ReportContent) -> str:
    notes = " ".join(n for m in content.models for n in m.notes)
    return f"The estimator found no mode in its band. {notes}".strip()


def _modes_table(content: ReportContent, modes: tuple[ComparedMode, ...]) -> Markup:
    true = content.truth is not None
    known = any(isfinite(r.confidence) for m in modes for r in m.readings)
    rows = [
        [*_mode_row(m, r, true), *([probability_text(r.confidence)] if known else [])]
        for m in modes
        for r in m.readings
    ]
    header = HEADER + (TRUTH if true else ()) + (("confidence",) if known else ())
    return html_table("Natural frequencies and damping", header, rows, range(2, len(header)), "modes")


def _mode_row(mode: ComparedMode, reading: ModeReading, true: bool) -> list[str]:
    cells = [
        str(mode.number),
        reading.test or "FRFs",
        with_sigma(reading.frequency_hz, reading.frequency_sigma_hz),
        with_sigma(100 * reading.damping, 100 * reading.damping_sigma),
        significant_digits(100 * reading.half_power, 3) if isfinite(reading.half_power) else "not readable",
    ]
    return cells + (_true_cells(reading) if true else [])


def _true_cells(reading: ModeReading) -> list[str]:
    if not isfinite(reading.true_frequency_hz):
        return [UNKNOWN, UNKNOWN]
    return [
        _difference_from_truth(
            reading.frequency_hz, reading.frequency_sigma_hz, reading.true_frequency_hz, reading.true_drift
        ),
        _difference_from_truth(100 * reading.damping, 100 * reading.damping_sigma, 100 * reading.true_damping),
    ]


def _difference_from_truth(value: float, sigma: float, truth: float, drift: float = 0.0) -> Markup:
    gap = joint_deviations(value, sigma, truth, truth * drift)
    error = relative_difference(value, truth) + (f" ({in_sigmas(gap)})" if isfinite(gap) else "")
    return join_markup([rounded_to_sigma(truth, sigma), html_element("br"), html_element("small", error)])


def _drift_sentence(content: ReportContent) -> Markup | None:
    if content.truth is None or not content.truth.drift:
        return None
    drift = relative_change(content.truth.drift)
    return paragraph(
        f"True values are those at the start; the bench's stiffness then drifts by {drift}. The σ beside an error "
        "allows for that."
    )


def _understated_uncertainty(modes: tuple[ComparedMode, ...]) -> Markup | None:
    """Where the truth shows that a stated uncertainty is too small."""
    off = [f"mode {m.number} ({r.test or 'FRFs'})" for m in modes for r in m.readings if _is_off_truth(r)]
    if not off:
        return None
    return paragraph(
        f"More than 3 σ off the truth: {list_in_words(off)}. For these the stated uncertainty is too small."
    )


def _is_off_truth(reading: ModeReading) -> bool:
    gaps = (
        joint_deviations(
            reading.frequency_hz,
            reading.frequency_sigma_hz,
            reading.true_frequency_hz,
            reading.true_frequency_hz * reading.true_drift,
        ),
        joint_deviations(reading.damping, reading.damping_sigma, reading.true_damping, 0.0),
    )
    return any(agreement_verdict(gap) == "disagree" for gap in gaps)


def _agreement_sentence(modes: tuple[ComparedMode, ...]) -> Markup | None:
    pairs = compare_tests(modes)
    if not pairs:
        return None
    first = pairs[0][0].readings
    rows = [
        (
            str(m.number),
            _difference_text(m.readings[0].frequency_hz, m.readings[1].frequency_hz, f),
            _difference_text(m.readings[0].damping, m.readings[1].damping, z),
            agreement_verdict(max(f, z)),
        )
        for m, f, z in pairs
    ]
    caption = f"Do the {first[0].test} and the {first[1].test} test agree?"
    explained = paragraph(
        "Two values agree if they lie no more than 2 σ apart, σ being that of their difference. A difference above "
        "3 σ is no chance: the structure changed (a shaker attached, a drift), or one of the tests or uncertainties "
        "is wrong."
    )
    return join_markup(
        [html_table(caption, ("mode", "difference in frequency", "in damping", "verdict"), rows, (1, 2)), explained]
    )


def _difference_text(a: float, b: float, gap: float) -> str:
    return relative_difference(b, a) + (f" ({in_sigmas(gap)})" if isfinite(gap) else "")
